"""Recordings on disk."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_ltl.errors import InvalidInputError
from drake_ltl.execution.recording import IntervalRecord, Recording, StepRecord
from drake_ltl.monitoring.violation import Violation


def make(samples: int = 5) -> Recording:
    """Two agents and an object; every number its own."""
    count = iter(range(10**6))

    def array(*shape: int) -> np.ndarray:
        size = int(np.prod(shape))
        return np.array([next(count) for _ in range(size)], dtype=float).reshape(shape)

    return Recording(
        scenario="name: made\n# µ",
        versions={"drake": "1.0"},
        seed=7,
        agents=("a1", "a2"),
        objects=("o1",),
        agent_radius={"a1": 1.25, "a2": 1.3},
        object_radius={"o1": 0.5},
        team_radius={"o1": 2.6},
        prefix_length=1,
        suffix_length=2,
        steps=(
            StepRecord(
                0,
                ({"kind": "travel", "agents": ["a1"], "object": None, "from": "pi1", "to": "pi2"},),
                0.0,
                1.5,
                True,
            ),
            StepRecord(1, (), 1.5, 0.25, False),
        ),
        completed=False,
        reason="interrupted",
        monitored=(Violation("weld", 1.5, 0, ("a1", "o1"), "the weld gapes", 0.004, 0.003, "m"),),
        intervals=(
            IntervalRecord(
                0, 1, {"a1": (0.5, 0.25, 0.0, 1.0)}, {"o1": (1.0, 2.0, 0.3)}, (), {"a2": ((0.0,) * 6, (1.0,) * 6)}
            ),
        ),
        time=np.linspace(0.0, 1.0, samples),
        q={"a1": array(samples, 4), "a2": array(samples, 6)},
        qd={"a1": array(samples, 4), "a2": array(samples, 6)},
        centre={"a1": array(samples, 3), "a2": array(samples, 3)},
        pose={"o1": array(samples, 7)},
        velocity={"o1": array(samples, 6)},
        step=np.arange(samples),
        phase=np.zeros(samples, dtype=int),
        mode=np.zeros((samples, 2), dtype=int),
        grasp=np.full((samples, 2), -1),
        lyapunov=array(samples),
        effort=array(samples, 2),
        manipulability=array(samples, 2),
    )


def assert_same(one: Recording, other: Recording) -> None:
    for field in dataclasses.fields(Recording):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b)
            assert a.dtype == b.dtype, field.name
        elif field.name in ("q", "qd", "centre", "pose", "velocity"):
            assert list(a) == list(b)
            for name in a:
                np.testing.assert_array_equal(a[name], b[name])
        else:
            assert a == b, field.name


@pytest.mark.parametrize("samples", [0, 1, 5])
def test_what_is_saved_is_loaded(tmp_path, samples):
    recording = make(samples)
    recording.save(tmp_path / "run.npz")
    assert_same(Recording.load(tmp_path / "run.npz"), recording)


def test_names_without_suffix_are_kept(tmp_path):
    make().save(tmp_path / "run")
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    assert_same(Recording.load(str(tmp_path / "run")), make())


def test_saving_twice_gives_the_same_bytes(tmp_path):
    for name in ("one", "two"):
        make().save(tmp_path / name)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_a_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "run.npz"
    path.write_text("precious", encoding="utf-8")

    def fail(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", fail)
    with pytest.raises(OSError, match="No space"):
        make().save(path)
    assert path.read_text(encoding="utf-8") == "precious"
    assert list(tmp_path.iterdir()) == [path]


def test_the_format_needs_no_library(tmp_path):
    """A zip of plain arrays and one JSON text: any language can read it."""
    make().save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz", allow_pickle=False) as archive:
        header = json.loads(archive["header"].tobytes())
        assert archive["q/a2"].shape == (5, 6)
    assert header["format"] == "drake_ltl recording"
    assert header["version"] == 6
    assert header["seed"] == 7
    assert header["steps"][0]["actions"][0]["kind"] == "travel"


def test_object_origins(tmp_path):
    np.testing.assert_array_equal(make().object_origin["o1"], make().pose["o1"][:, 4:7])


def refusal(path) -> str:
    with pytest.raises(InvalidInputError) as caught:
        Recording.load(path)
    (mistake,) = caught.value.mistakes
    assert mistake.where == str(path)
    assert "\n" not in str(mistake)
    return mistake.what


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "run.npz"
    make().save(path)
    return path.read_bytes()


def test_files_that_are_not_there(tmp_path):
    assert "No such file" in refusal(tmp_path / "nothing.npz")
    assert refusal(tmp_path)  # a folder


OTHER_KIND = "not a recording but a file of another kind"
OTHER_ARCHIVE = "not a recording but another archive"
DAMAGED = "is a damaged archive: it is cut off, or was changed"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"hello\n", OTHER_KIND),
        (b"name: case_ii\n", OTHER_KIND),
        (b"\x93NUMPY", OTHER_KIND),
        (b"\x00" * 100, OTHER_KIND),
        (b"PK\x03\x04", DAMAGED),
    ],
)
def test_files_of_another_kind(tmp_path, content, words):
    path = tmp_path / "run.npz"
    path.write_bytes(content)
    assert words in refusal(path)


def test_a_single_array_is_no_recording(tmp_path):
    np.save(tmp_path / "array.npy", np.zeros(3))
    assert OTHER_KIND in refusal(tmp_path / "array.npy")


def test_pickles_are_not_loaded(tmp_path):
    np.savez(tmp_path / "evil.npz", header=np.array([{"format": "drake_ltl recording"}], dtype=object))
    assert DAMAGED in refusal(tmp_path / "evil.npz")


def test_other_archives(tmp_path):
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    assert OTHER_ARCHIVE in refusal(tmp_path / "other.npz")
    with zipfile.ZipFile(tmp_path / "some.zip", "w") as archive:
        archive.writestr("header", "{}")
    assert OTHER_ARCHIVE in refusal(tmp_path / "some.zip")


def test_an_archive_that_would_fill_the_memory(tmp_path):
    """8 GB of zeros in 8 MB; here less."""
    np.savez_compressed(tmp_path / "bomb.npz", header=np.zeros(3, dtype=np.uint8), x=np.zeros(3 * 10**6))
    assert "times its size" in refusal(tmp_path / "bomb.npz")


PARTS = "is a damaged recording: its parts do not fit together"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"version": 7}, "of the newer version 7, and this release reads up to version 6"),
        ({"version": 0}, "is a damaged recording: it has no version"),
        ({"version": True}, "is a damaged recording: it has no version"),
        ({"version": None}, "is a damaged recording: it has no version"),
        ({"version": ...}, "is a damaged recording: it has no version"),
        ({"format": "another"}, OTHER_ARCHIVE),
        ({"format": ...}, OTHER_ARCHIVE),
        ({"intervals": [{"step": 0}]}, "it lacks 'phase'"),
        ({"agents": ["a1", "a9"]}, "it lacks 'q/a9'"),
        ({"agents": ["a1", 5000 * "x"]}, f"it lacks 'q/{74 * 'x'}..."),
        ({"agents": None}, PARTS),
        ({"steps": [{"number": 0}]}, "it lacks 'actions'"),
        ({"steps": 3}, PARTS),
        ({"reason": ...}, "it lacks 'reason'"),
    ],
)
def test_headers_that_do_not_fit(tmp_path, change, words):
    make().save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as archive:
        arrays = dict(archive)
    header = json.loads(arrays["header"].tobytes()) | change
    header = {key: value for key, value in header.items() if value is not ...}
    arrays["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    np.savez(tmp_path / "changed.npz", **arrays)
    assert words in refusal(tmp_path / "changed.npz")


def saved_parts(tmp_path) -> tuple[dict, dict]:
    """Header and arrays of a sound file."""
    make().save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as archive:
        arrays = dict(archive)
    return json.loads(arrays["header"].tobytes()), arrays


def refused(tmp_path, header: dict, arrays: dict) -> str:
    text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    np.savez(tmp_path / "changed.npz", **(arrays | {"header": text}))
    return refusal(tmp_path / "changed.npz")


INTEGER = [5.0, "4", None, True, float("nan"), 10**400]
NUMBER = ["x", None, True, float("nan"), float("inf"), 10**400, [1.0]]
KINDS = {
    "scenario": [5, None, []],
    "versions": [5, None],
    "agent_radius": [None, [1.0], {"a1": 10**400}, {"a1": "1"}, {"a1": True}, {"a1": float("nan")}],
    "object_radius": [None, {"o1": None}],
    "team_radius": [None, {"o1": 1e308}],
    "prefix_length": INTEGER,
    "suffix_length": INTEGER,
    "completed": ["no", 1, None],
    "reason": [5, None],
    "seed": [None, "7", -1, 1.0, True, 2**63],
    "lacks": [None, "effort", [5]],
    "steps.0.number": INTEGER,
    "steps.0.actions": ["x", {}, [5], [None], [{}]],
    "steps.0.start": NUMBER,
    "steps.0.duration": NUMBER,
    "steps.0.finished": [1, "yes", None],
    "steps.0.actions.0.agents": [None, 5, "a1", [1], [["a1"]]],
    "steps.0.actions.0.object": [5, []],
    "steps.0.actions.0.kind": [None, ["travel"]],
    "steps.0.actions.0.from": [None, ["pi1"]],
    "monitored.0.monitor": [None, 5],
    "monitored.0.time": NUMBER,
    "monitored.0.step": INTEGER,
    "monitored.0.who": [None, "a1", [5]],
    "monitored.0.what": [None, 5],
    "monitored.0.value": ["x", True, float("nan"), float("inf")],
    "monitored.0.limit": ["x", [1.0]],
    "monitored.0.unit": [None, 5],
    "intervals.0.step": INTEGER,
    "intervals.0.phase": INTEGER,
    "intervals.0.travels.a1": ["abcd", ["x"] * 4, [None] * 4, [float("nan")] * 4, [float("inf")], [[0.0]]],
    "intervals.0.transports.o1": ["abc", ["x"], [1e300]],
    "intervals.0.waiting": ["o1", [5]],
    "intervals.0.reaches.a2": [["ab", "cd"], [["x"], [0.0]]],
}


@pytest.mark.parametrize(("place", "value"), [(place, value) for place, values in KINDS.items() for value in values])
def test_headers_with_something_of_another_kind(tmp_path, place, value):
    header, arrays = saved_parts(tmp_path)
    *parents, last = (int(key) if key.isdigit() else key for key in place.split("."))
    inner = header
    for key in parents:
        inner = inner[key]
    inner[last] = value
    what = refused(tmp_path, header, arrays)
    assert what.startswith("is damaged: ") or what == PARTS


@pytest.mark.parametrize("name", ["step", "phase", "mode", "grasp", "time", "lyapunov", "effort", "q/a1", "pose/o1"])
def test_arrays_of_another_kind(tmp_path, name):
    header, arrays = saved_parts(tmp_path)
    kinds = ["U3", "S3", "M8[s]", "m8[s]", "bool", "c16", "f2", "f4", "g", "i1", "u8", ">i8", ">f8"]
    kinds.append("f8" if arrays[name].dtype == np.int64 else "i8")
    for kind in kinds:
        changed = np.zeros(arrays[name].shape, dtype=kind)
        assert f"is damaged: {name} is an array of" in refused(tmp_path, header, arrays | {name: changed})


@pytest.mark.parametrize("header", [b"[1, 2]", b"3", b"not json", b"\xff\xff", b"null"])
def test_headers_that_are_none(tmp_path, header):
    make().save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as archive:
        arrays = dict(archive) | {"header": np.frombuffer(header, dtype=np.uint8)}
    np.savez(tmp_path / "changed.npz", **arrays)
    assert OTHER_ARCHIVE in refusal(tmp_path / "changed.npz")


@pytest.mark.parametrize("name", ["time", "q/a1", "pose/o1", "grasp"])
def test_arrays_that_are_missing_or_short(tmp_path, name):
    make().save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as archive:
        arrays = dict(archive)
    np.savez(tmp_path / "short.npz", **(arrays | {name: arrays[name][:-1]}))
    assert PARTS in refusal(tmp_path / "short.npz")
    np.savez(tmp_path / "single.npz", **(arrays | {name: np.float64(3.0)}))
    assert PARTS in refusal(tmp_path / "single.npz")
    del arrays[name]
    np.savez(tmp_path / "missing.npz", **arrays)
    assert f"it lacks {name!r}" in refusal(tmp_path / "missing.npz")


@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_truncated_files(tmp_path_factory, whole, share):
    path = tmp_path_factory.mktemp("cut") / "run.npz"
    length = int(share * len(whole))
    path.write_bytes(whole[:length])
    assert ("is empty" if length == 0 else OTHER_KIND if length == 1 else DAMAGED) in refusal(path)


@given(place=st.floats(0.0, 1.0, exclude_max=True), flip=st.integers(1, 255))
def test_damaged_files_are_refused_or_harmless(tmp_path_factory, whole, place, flip):
    """A byte that tumbled: no other error escapes, and nothing else is ever loaded."""
    content = bytearray(whole)
    content[int(place * len(content))] ^= flip
    path = tmp_path_factory.mktemp("damaged") / "run.npz"
    path.write_bytes(content)
    with contextlib.suppress(InvalidInputError):
        assert_same(Recording.load(path), make())  # a byte that means nothing, such as a date
