"""The journal of a sweep."""

from __future__ import annotations

import dataclasses
import json

import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.sweep.journal import NAME, Journal, header_of
from drake_ltl.sweep.outcome import Outcome

HEADER = {
    "format": "drake_ltl sweep",
    "version": 1,
    "scenario": "name: x\n",
    "seed": 3,
    "gains": 5.0,
    "masses": 1.0,
    "suffix_rounds": 1,
    "versions": {"drake_ltl": "0.1.0"},
}


def refusal(folder, header=HEADER) -> str:
    """The one line with which a journal is refused; it is left as it was."""
    before = (folder / NAME).read_bytes()
    with pytest.raises(InvalidInputError) as caught:
        Journal(folder, header)
    assert (folder / NAME).read_bytes() == before
    (line,) = str(caught.value).splitlines()
    assert NAME in line
    return line


def test_outcomes_come_back_as_they_were(tmp_path, outcome):
    outcomes = [outcome(4), outcome(0, "stalled", clearance=None), Outcome(2, "failed", reason="its worker ended")]
    with Journal(tmp_path / "new" / "folder", HEADER) as journal:
        for one in outcomes:
            journal.add(one)
    with Journal(tmp_path / "new" / "folder", HEADER) as journal:
        assert journal.outcomes == {one.run: one for one in outcomes}


def test_an_outcome_is_on_the_disk_when_it_is_added(tmp_path, outcome):
    with Journal(tmp_path, HEADER) as journal:
        journal.add(outcome(1))
        lines = (tmp_path / NAME).read_bytes().splitlines()
        assert json.loads(lines[1])["run"] == 1


@pytest.mark.parametrize("cut", [1, 30, 200])
def test_a_line_that_was_cut_off_is_dropped(tmp_path, outcome, cut):
    with Journal(tmp_path, HEADER) as journal:
        journal.add(outcome(0))
        journal.add(outcome(1))
    whole = (tmp_path / NAME).read_bytes()
    (tmp_path / NAME).write_bytes(whole[:-cut])
    with Journal(tmp_path, HEADER) as journal:
        assert set(journal.outcomes) == {0}
        journal.add(outcome(1))
    assert (tmp_path / NAME).read_bytes() == whole


def test_a_header_that_was_cut_off_is_written_anew(tmp_path):
    Journal(tmp_path, HEADER).close()
    whole = (tmp_path / NAME).read_bytes()
    for length in (0, 3, 40):
        (tmp_path / NAME).write_bytes(whole[:length])
        Journal(tmp_path, HEADER).close()
        assert (tmp_path / NAME).read_bytes() == whole


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("scenario", "name: y\n", "of another scenario"),
        ("seed", 4, "of another seed"),
        ("gains", 6.0, "other changes of gains"),
        ("masses", 0.0, "other changes of masses"),
        ("suffix_rounds", 2, "of other rounds"),
        ("versions", {"drake_ltl": "0.2.0"}, "by other versions"),
    ],
)
def test_another_sweep_is_refused(tmp_path, key, value, words):
    Journal(tmp_path, HEADER).close()
    assert words in refusal(tmp_path, HEADER | {key: value})


@pytest.mark.parametrize(
    "data", [b"notes", b"notes\n", b"[1, 2]\n", b'{"format": 3}\n', b"\x00\xff\n", b'{"a": 1}\n{"b": ']
)
def test_other_files_are_refused_and_left_alone(tmp_path, data):
    (tmp_path / NAME).write_bytes(data)
    assert "is not a sweep's journal" in refusal(tmp_path)


def test_other_versions_of_journals_are_refused(tmp_path):
    Journal(tmp_path, HEADER | {"version": 2}).close()
    assert "is of version 2" in refusal(tmp_path)


@pytest.mark.parametrize("line", ["", "[]", "{}", '{"run": "x", "drawn": null, "status": "satisfied"}', '{"run": 1'])
def test_damage_is_named_by_its_line(tmp_path, outcome, line):
    with Journal(tmp_path, HEADER) as journal:
        journal.add(outcome(0))
    with open(tmp_path / NAME, "a", encoding="utf-8") as file:
        file.write(line + "\n")
    assert "line 3 is damaged" in refusal(tmp_path)


def test_two_sweeps_in_one_folder(tmp_path):
    with Journal(tmp_path, HEADER):
        assert "another sweep is writing it" in refusal(tmp_path)
    Journal(tmp_path, HEADER).close()


def test_a_header_has_all_that_outcomes_depend_on(sweep):
    header = header_of(sweep)
    assert set(header) == set(HEADER)
    assert json.loads(json.dumps(header)) == header
    for change in ({"seed": 4}, {"gains": 1.0}, {"masses": 0.0}, {"suffix_rounds": 2}):
        assert header_of(dataclasses.replace(sweep, **change)) != header
