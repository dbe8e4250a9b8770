import dataclasses
import itertools
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from drake_ltl.visualization.figures import run_drawings, write_report_figures
from drake_ltl.visualization.style import RC
from drake_ltl.visualization.time_figures import _draw_clearances, _draw_lyapunov, least_in_buckets
from drake_ltl.visualization.top_view import View, draw_step, samples_of
from drake_ltl.visualization.trajectory_figures import _draw_sheet, _joined, _sheet

PNG = b"\x89PNG\r\n\x1a\n"


def test_report_has_a_figure_for_each_step_and_the_curves(recording, scenario, tmp_path):
    paths = write_report_figures(recording, scenario, tmp_path / "report")
    names = ["step_01", "step_02", "step_03", "step_04", "steps", "gantt", "clearances", "lyapunov", "effort"]
    assert [path.name for path in paths] == [f"{name}.png" for name in names]
    assert all(path.read_bytes().startswith(PNG) for path in paths)


def test_vector_figures_are_the_same_for_the_same_recording(recording, scenario):
    first, second = ({drawing.name: drawing for drawing in run_drawings(recording, scenario)} for _ in range(2))
    for name in ("gantt", "step_03"):
        kinds = first[name].render(("svg", "pdf", "page"))
        assert kinds == second[name].render(("svg", "pdf", "page"))
        assert b"<text" in kinds["svg"]
        assert b"<text" not in kinds["page"]  # letters are outlines there


def test_a_run_that_stopped_at_once_is_drawn_as_far_as_it_went(recording, scenario, tmp_path):
    def cut(array):
        return array[:1]

    groups = {
        field: {name: cut(array) for name, array in getattr(recording, field).items()}
        for field in ("q", "qd", "centre", "pose", "velocity")
    }
    names = ("time", "step", "phase", "mode", "grasp", "lyapunov", "effort", "manipulability")
    arrays = {field: cut(getattr(recording, field)) for field in names}
    step = dataclasses.replace(recording.steps[0], duration=0.0, finished=False)
    one_sample = dataclasses.replace(recording, steps=(step,), completed=False, **groups, **arrays)
    assert len(write_report_figures(one_sample, scenario, tmp_path)) == 6


def test_a_step_is_drawn_with_begin_end_and_team(recording, scenario):
    axes = Figure().add_subplot()
    draw_step(axes, View.of(recording, scenario), recording.steps[2])
    circles = [(patch.center, patch.radius) for patch in axes.patches if hasattr(patch, "center")]
    assert {radius for _, radius in circles} == {1.0, 3.0}
    team = [centre[0] for centre, radius in circles if radius == 3.0]
    np.testing.assert_allclose(team, [10.0, -10.0])  # where it sets out and where it sets down
    assert {text.get_text() for text in axes.texts} == {"a", "b", "crate", "idle"}
    lengths = {len(line.get_xdata()) for line in axes.lines}
    assert len(axes.lines) == 3  # a, b and the crate; what stays has no way
    assert lengths == {len(samples_of(recording, recording.steps[2]))}


def test_no_team_is_drawn_in_steps_that_carry_nothing(recording, scenario):
    for step in (recording.steps[1], recording.steps[3]):
        axes = Figure().add_subplot()
        draw_step(axes, View.of(recording, scenario), step)
        assert 3.0 not in {getattr(patch, "radius", None) for patch in axes.patches}


def test_lyapunov_is_not_drawn_across_steps(recording):
    figure = Figure()
    _draw_lyapunov(figure, recording)
    (axes,) = figure.axes
    curves = [line for line in axes.lines if len(line.get_xdata()) > 2]
    assert len(curves) == 2
    assert axes.get_yscale() == "log"
    assert {text.get_text() for text in axes.texts} == {"1", "2", "3", "4"}


def test_a_run_without_motion_still_has_its_figures(recording, scenario):
    still = dataclasses.replace(recording, lyapunov=np.zeros_like(recording.lyapunov))
    for draw in (_draw_lyapunov, lambda figure, run: _draw_clearances(figure, run, scenario)):
        figure = Figure()
        draw(figure, still)
        figure.savefig("/dev/null", format="png")


def test_no_minimum_is_lost_in_drawing():
    value = np.ones(100_000)
    value[54_321] = -0.5
    t, least = least_in_buckets(np.arange(len(value), dtype=float), value)
    assert len(t) < 5000
    assert least.min() == -0.5


@pytest.mark.parametrize("width", [30, 50, 200])
def test_joined_lines_keep_every_part_whole(width):
    parts = ["a: west → east", "b grasps crate in east", "c"]
    lines = _joined(parts, width)
    assert [part for line in lines for part in line.split("    ")] == parts
    assert all(len(line) <= width for line in lines)


def test_a_part_longer_than_a_line_is_broken_between_words():
    lines = _joined(["one + two carry crate: west → east", "c"], 20)
    assert lines == ["one + two carry", "    crate: west →", "    east    c"]
    assert all(len(line) <= 20 for line in _joined(["x" * 90], 20))


@pytest.mark.parametrize("count", [1, 2, 4])
def test_titles_of_the_sheet_are_neither_cut_nor_in_each_other_s_way(recording, scenario, count):
    team = ["robot_one", "robot_two", "robot_three"]
    long = {"kind": "transport", "agents": team, "object": "a_heavy_crate_of_steel", "from": "west", "to": "east"}
    steps = [dataclasses.replace(step, actions=(long, *step.actions)) for step in recording.steps[:count]]
    run = dataclasses.replace(recording, steps=tuple(steps))
    rows, columns, size = _sheet(run.steps)
    with mpl.rc_context(RC):
        figure = Figure(figsize=size, layout="constrained")
        _draw_sheet(figure, View.of(run, scenario), rows, columns)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        titles = [text for axes in figure.axes for text in axes.findobj(Text) if "robot_three" in text.get_text()]
        boxes = [title.get_window_extent(canvas.get_renderer()) for title in titles]
        pictures = [axes.get_window_extent(canvas.get_renderer()) for axes in figure.axes]
    assert len(boxes) == count
    for box in boxes:
        assert 0.0 <= box.x0 < box.x1 <= figure.bbox.width
        assert 0.0 <= box.y0 < box.y1 <= figure.bbox.height
    for one, other in itertools.combinations(boxes, 2):
        assert not one.overlaps(other)
    for box, picture in itertools.product(boxes, pictures):
        assert not box.overlaps(picture)


def test_figures_do_not_need_drake():
    code = "import sys, drake_ltl.visualization.figures; sys.exit('pydrake' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
