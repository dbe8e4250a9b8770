from drake_ltl.visualization.words import action_words, actions_words, step_heading


def test_every_kind_of_action_is_a_sentence(recording):
    words = [action_words(action) for step in recording.steps for action in step.actions]
    assert words == [
        "a: west → east",
        "b: west → east",
        "a grasps crate in east",
        "b grasps crate in east",
        "a + b carry crate: east → west",
        "a releases crate in west",
    ]


def test_one_agent_carries():
    action = {"kind": "transport", "agents": ["a"], "object": "o", "from": "p", "to": "q"}
    assert action_words(action) == "a carries o: p → q"


def test_nothing_to_do_is_said():
    assert actions_words([]) == ["all wait"]


def test_headings_say_which_part_of_the_run_it_is(recording):
    assert step_heading(recording.steps[1], recording) == "Step 2 of 4 (prefix)"
    assert step_heading(recording.steps[2], recording) == "Step 3 of 4 (suffix, round 1)"
