"""The second look at runs is right by itself, and finds what is wrong."""

from __future__ import annotations

import json
from random import Random

import numpy as np
import pytest

from drake_ltl.verification.ltl import holds

REGIONS = ("north", "east")


def formula(chance: Random, depth: int) -> tuple:
    head = chance.choice(["is", "is", "true"]) if depth == 0 else chance.choice(["!", "X", "F", "G", "&", "|", "U"])
    if head in ("is", "true"):
        return (head, "a1", chance.choice(REGIONS)) if head == "is" else (head,)
    return (head, *(formula(chance, chance.randrange(depth)) for _ in range(2 if head in "&|U" else 1)))


def test_spot_says_the_same_of_words(program):
    look, written, chance = program("second_look"), program("random_missions").written, Random(0)
    verdicts = []
    for _ in range(60):
        tree = formula(chance, 4)
        word = [{"a1": chance.choice([*REGIONS, None])} for _ in range(chance.randint(1, 5))]
        loop = chance.randrange(len(word))
        letters = [{f"a1.{letter['a1']}"} for letter in word]
        verdicts.append(look.truth(tree, word, loop)[0])
        assert verdicts[-1] == holds(written(tree), letters[:loop], letters[loop:]), (tree, word, loop)
    assert 10 < sum(verdicts) < 50


@pytest.fixture
def recorded(case_ii_run, tmp_path):
    """recorded(change): the run's file, with other arrays or another header."""

    def make(change=lambda arrays, header: None):
        path = tmp_path / "run.npz"
        case_ii_run.recording.save(path)
        with np.load(path) as archive:
            arrays = dict(archive)
        header = json.loads(arrays["header"].tobytes())
        header["suffix_length"] *= 2  # both rounds are one
        change(arrays, header)
        arrays["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
        np.savez(path, **arrays)
        return path

    return make


@pytest.mark.mission
def test_a_sound_run(program, recorded, case_ii_run):
    """Its own trigonometry has the spheres where Drake has them."""
    look, formulas = program("second_look"), program("many_runs").FORMULAS["case_ii"]
    path = recorded()
    assert look.findings(path, formulas) == []
    seen = look.Look(path)
    for name in seen.agents:
        np.testing.assert_allclose(seen.centre[name], case_ii_run.recording.centre[name], atol=1e-9)


def beside(name: str, other: str):
    """All the time an agent stands where another does."""

    def change(arrays, header):
        arrays[f"q/{name}"] = arrays[f"q/{other}"] + [0.5, 0.0, 0.0, 0.0]

    return change


def far_out(arrays, header):
    arrays["q/a1"] = arrays["q/a1"] + [29.0, 0.0, 0.0, 0.0]


def cut_off(arrays, header):
    header["steps"][-1]["finished"] = False


def another_way(arrays, header):
    for step in header["steps"]:
        for action in step["actions"]:
            action["to"] = action["from"]


@pytest.mark.mission
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (beside("a1", "a2"), "a1 and a2 overlap"),
        (far_out, "a1 leaves the workspace"),
        (cut_off, "ended after"),
        (another_way, "has not come to"),
    ],
)
def test_what_is_wrong_is_found(program, recorded, change, words):
    assert any(words in found for found in program("second_look").findings(recorded(change), ()))


@pytest.mark.mission
def test_formulas_that_do_not_hold(program, recorded):
    look, path = program("second_look"), recorded()
    for tree in program("many_runs").FORMULAS["case_ii"]:
        assert look.findings(path, [("!", tree)]) == [f"the word does not satisfy {('!', tree)}"]
