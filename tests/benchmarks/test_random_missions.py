"""Random missions are scenarios, the same for the same seed, and their trees are their formulas."""

from __future__ import annotations

import json

import pytest

from drake_ltl.scenario import loads


def test_what_is_drawn_can_be_read(program):
    missions = program("random_missions")
    sizes = set()
    for seed in range(40):
        try:
            drawn = missions.draw(seed)
        except missions.CrowdedError:
            continue
        assert drawn == missions.draw(seed)
        scenario = loads(drawn.text)
        members = (*scenario.agents, *scenario.objects)
        sizes.add((len(scenario.agents), len(scenario.objects), len(scenario.regions)))
        own = [missions.written(tree, alone=True) for tree in drawn.formulas[:-1]]
        assert own == [member.spec for member in members]
        assert missions.written(drawn.formulas[-1]) == scenario.spec
    assert len(sizes) > 4


@pytest.mark.parametrize("end", ["", '{"run": 2, "sta'])
def test_a_journal_goes_on(program, tmp_path, end):
    """What was cut off is dropped, and its run done again; a journal of another seed is refused."""
    many, path = program("many_runs"), tmp_path / "many_runs.jsonl"
    assert many.resumed(path, 1) == {}
    path.write_text(path.read_text() + json.dumps({"run": 1}) + "\n" + end)
    assert many.resumed(path, 1) == {1: {"run": 1}}
    assert len(path.read_text().splitlines()) == 2
    with pytest.raises(SystemExit, match="another seed"):
        many.resumed(path, 2)


def test_every_run_has_a_mission(program):
    """The cases come again and again, and never two at once."""
    cases = program("many_runs").CASES
    numbers = [{n for n in range(1000) if n % every == first} for every, first in cases.values()]
    assert [len(found) for found in numbers] == [20, 10]
    assert not set.intersection(*numbers)
