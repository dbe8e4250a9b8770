"""Outputs are tried before the work, and nothing is left of the trial."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from drake_ltl.cli import plan, simulate
from drake_ltl.cli.outcome import check_writable, write_json
from drake_ltl.errors import InvalidInputError

NOWHERE = Path("/proc/no_file")
"""A folder that is there and in which nobody, not even root, can make anything."""


def mistakes(*paths, **options) -> list[str]:
    with pytest.raises(InvalidInputError) as caught:
        check_writable(*paths, **options)
    return [str(mistake) for mistake in caught.value.mistakes]


def test_nothing_is_changed_and_nothing_is_left(tmp_path):
    kept = tmp_path / "kept"
    kept.write_text("kept", encoding="utf-8")
    os.utime(kept, (1.0, 1.0))
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "target")
    check_writable(
        kept, link, tmp_path / "new", None, replaced=tmp_path / "other", folder=tmp_path / "deep" / "er" / "folder"
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kept", "link"]
    assert link.is_symlink()
    assert kept.read_text(encoding="utf-8") == "kept"
    assert kept.stat().st_mtime == 1.0


def test_a_folder_that_is_there_stays(tmp_path):
    check_writable(folder=tmp_path)
    assert tmp_path.is_dir()


def test_every_output_that_cannot_be_written_is_named(tmp_path):
    lines = mistakes(NOWHERE, tmp_path, tmp_path / "no" / "file", replaced=Path("/dev/full"), folder=NOWHERE / "deep")
    assert [line.split(": ")[0] for line in lines] == [
        str(NOWHERE), str(tmp_path), str(tmp_path / "no" / "file"), "/dev/full", str(NOWHERE / "deep")
    ]  # fmt: skip
    assert "cannot be written" in lines[0]
    assert "is a folder" in lines[1]
    assert "there is no folder" in lines[2]
    assert "not a plain file" in lines[3]  # it would be replaced


def test_a_file_that_is_read_only(tmp_path, monkeypatch):
    """For root no file is: what the system would say to others."""
    monkeypatch.setattr(os, "open", lambda *args: (_ for _ in ()).throw(PermissionError(13, "Permission denied")))
    (line,) = mistakes(tmp_path / "file")
    assert line.startswith(f"{tmp_path / 'file'}: cannot be written (Permission denied)")


def test_a_report_cannot_be_where_a_file_is(tmp_path):
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", tmp_path / "file" / "deep"):
        (line,) = mistakes(folder=folder)
        assert line.startswith(f"{folder}: cannot be written")


def test_two_outputs_cannot_be_one_file(tmp_path):
    (line,) = mistakes(tmp_path / "a", tmp_path / "b", replaced=tmp_path / ".." / tmp_path.name / "a")
    assert "several outputs" in line


def test_the_input_is_not_overwritten(tmp_path):
    source = tmp_path / "plan.json"
    source.write_text("precious", encoding="utf-8")
    (tmp_path / "symbolic").symlink_to(source)
    (tmp_path / "hard").hardlink_to(source)
    for name in ("plan.json", "symbolic", "hard"):
        for options in ({}, {"replaced": tmp_path / name}):
            paths = [] if options else [tmp_path / name]
            (line,) = mistakes(*paths, source=source, **options)
            assert line == f"{tmp_path / name}: is the input, and would be overwritten; name another file"
    (line,) = mistakes(source=source, folder=tmp_path, inside=("plan.txt", "plan.json"))
    assert line.startswith(f"{source}: is the input")
    check_writable(tmp_path / "other", None, source=source, folder=tmp_path, inside=("plan.txt",))
    check_writable(tmp_path / "other", source=tmp_path / "not there")
    check_writable(Path("/dev/null"), source=Path("/dev/null"))


@pytest.mark.parametrize(
    ("command", "option"),
    [
        ("plan", "--json"),
        ("simulate", "--json"),
        ("simulate", "--recording"),
        ("simulate", "--record"),
        ("simulate", "--graphviz"),
        ("verify", "--json"),
        ("view", "--record"),
    ],
)
def test_no_command_overwrites_its_input(drake_ltl, tmp_path, command, option):
    path = tmp_path / "input"
    path.write_text("precious", encoding="utf-8")
    result = drake_ltl(command, path, option, path)
    assert result.status == 2
    assert result.err.splitlines() == [f"{path}: is the input, and would be overwritten; name another file"]
    assert path.read_text(encoding="utf-8") == "precious"


@pytest.mark.parametrize(
    ("command", "option", "names"), [("plan", "--outputs", plan.OUTPUTS), ("simulate", "--report", simulate.REPORT)]
)
def test_nor_by_what_it_writes_into_a_folder(drake_ltl, shuttle_file, tmp_path, command, option, names):
    for name in names:
        shuttle_file = shuttle_file.rename(tmp_path / name)
        assert "is the input" in drake_ltl(command, shuttle_file, option, tmp_path).err


def test_the_files_in_the_folder_are_known(drake_ltl, shuttle_file, tmp_path):
    assert drake_ltl("plan", shuttle_file, "--outputs", tmp_path / "out").status == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == set(plan.OUTPUTS)


def test_pipes_are_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    check_writable(tmp_path / "pipe")


def test_a_full_disk_is_named():
    with pytest.raises(OSError, match="No space left") as caught:
        write_json(Path("/dev/full"), {"a": 1})
    assert caught.value.filename == "/dev/full"
