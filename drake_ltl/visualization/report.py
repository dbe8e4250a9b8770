"""The report of a run: one HTML file that needs nothing else, and its figures as files."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from string import Template

from drake_ltl.errors import naming_file
from drake_ltl.execution.recording import Recording
from drake_ltl.planning.demands import spaced
from drake_ltl.planning.geometry import Geometry
from drake_ltl.planning.plan import Plan
from drake_ltl.planning.table import plan_table
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import check_starts
from drake_ltl.shown import to_html
from drake_ltl.verification.data import finite_part
from drake_ltl.verification.table import verdict_table
from drake_ltl.verification.verdict import Verdict
from drake_ltl.visualization.automaton_drawing import AutomatonGraph, automaton_graphs, automaton_pdf, automaton_svg
from drake_ltl.visualization.evidence import evidence
from drake_ltl.visualization.figures import run_drawings
from drake_ltl.visualization.force_figures import team_forces
from drake_ltl.visualization.page_overlay import page_file
from drake_ltl.visualization.scenario_map import map_drawing
from drake_ltl.visualization.style import Drawing
from drake_ltl.visualization.words import actions_words
from drake_ltl.whole_files import written_whole

NAME = "report.html"
FIGURES = "figures"
"""Their folder, beside the page."""
FORMATS = ("svg", "pdf")
MOST_STEPS = 24
"""Steps whose ways are shown one by one; of longer runs the first."""
MOST_EDGES = 60
"""Of an automaton whose edges are listed."""


def write_report(
    directory: Path | str,
    recording: Recording,
    scenario: Scenario,
    verdict: Verdict,
    *,
    geometry: Geometry,
    plan: Plan | None = None,
) -> list[Path]:
    """Writes report.html, and into the folder `figures` every figure as SVG and PDF; makes what folders are missing.

    Args:
        scenario: the one the recording was made of.
        verdict: of the recording.
        geometry: of the scenario's models, for the map.
        plan: what was to be carried out; without it the executed steps alone are shown.

    Returns:
        The files, the report first.

    Raises:
        OSError: a file cannot be written.
    """
    page, folder = Path(directory) / NAME, Path(directory) / FIGURES
    folder.mkdir(parents=True, exist_ok=True)
    drawings = [map_drawing(scenario, geometry, check_starts(scenario, geometry))]
    drawings += run_drawings(recording, scenario, lambda: team_forces(finite_part(recording), scenario))
    pictures = {}
    files = [page]
    for drawing in drawings:
        rendered = drawing.render((*FORMATS, "page") if _is_shown(drawing) else FORMATS[:1])
        if "page" in rendered:
            pictures[drawing.name] = Picture(drawing.title, rendered.pop("page").decode())
        for kind, content in rendered.items():
            files.append(folder / f"{drawing.name}.{kind}")
            _write(files[-1], content)
    graphs = [(graph, automaton_svg(graph)) for graph in automaton_graphs(scenario)]
    for number, (graph, svg) in enumerate(graphs, start=1):
        for kind, content in (("svg", svg.encode()), ("pdf", automaton_pdf(graph))):
            files.append(folder / f"automaton_{number}.{kind}")
            _write(files[-1], content)
    _write(page, report_html(recording, scenario, verdict, pictures, graphs, plan).encode())
    return files


@dataclass(frozen=True)
class Picture:
    """A figure in the page."""

    title: str
    svg: str


def _is_shown(drawing: Drawing) -> bool:
    """Of a long run's steps the first alone."""
    number = drawing.name.removeprefix("step_")
    return not number.isdigit() or int(number) <= MOST_STEPS


def _write(path: Path, content: bytes) -> None:
    with naming_file(path), written_whole(path) as file:
        file.write(content)


def report_html(
    recording: Recording,
    scenario: Scenario,
    verdict: Verdict,
    figures: Mapping[str, Picture],
    graphs: Sequence[tuple[AutomatonGraph, str]],
    plan: Plan | None = None,
) -> str:
    """The whole page.

    Args:
        figures: by the names of their files.
        graphs: automata and what they look like, as SVG.
    """
    sections = [
        ("Verdict", [to_html(verdict_table(verdict, scenario)), _evidence(recording, scenario, verdict)]),
        ("Scenario", [*_pictures(figures, "map"), _source(recording.scenario)]),
        ("Plan", [to_html(plan_table(plan, scenario)) if plan else "", *_pictures(figures, "gantt")]),
        ("Steps", [_steps(recording, figures)]),
        ("Clearances", _pictures(figures, "clearances")),
        ("Lyapunov function", _pictures(figures, "lyapunov")),
        ("Forces, shares and torques", [_FORCES, *_pictures(figures, "forces", "effort")]),
        ("Automata", [_AUTOMATA, *(_automaton(n, *graph) for n, graph in enumerate(graphs, 1))] if graphs else []),
        ("Versions", [_versions(recording)]),
    ]
    shown = [(title, "\n".join(parts)) for title, parts in sections if any(parts)]
    return Template(page_file("report.html")).substitute(
        title=escape(scenario.name or "mission"),
        css=page_file("report.css"),
        verdict="satisfied" if verdict.satisfied else "violated",
        summary=_summary(recording, verdict),
        contents="".join(f'<li><a href="#{_anchor(title)}">{title}</a></li>' for title, _ in shown),
        body="".join(
            f'<section id="{_anchor(title)}"><h2>{title}</h2>\n{content}\n</section>\n' for title, content in shown
        ),
    )


_FORCES = (
    "<p>Horizontal forces during transports, worked out from the recorded motion by Newton's law: what moves the "
    "object and all who carry it, and what each member hands on to the object when its own mass has been moved. The "
    "shares are the c<sub>&tau;</sub> of the control law (10b), in proportion to the powers. Torques are what the "
    "controllers asked for, relative to the actuators' limits.</p>"
)
_AUTOMATA = (
    "<p>B&uuml;chi automata of the formulas: a run is accepted if it meets states with a double border again and "
    "again. They read one letter for each plan step.</p>"
)


def _summary(recording: Recording, verdict: Verdict) -> str:
    done = sum(step.finished for step in recording.steps)
    parts = [f"{done} of {len(recording.steps)} steps done", f"{verdict.simulated_seconds:.1f} s simulated"]
    for names, kind in ((recording.agents, "agent"), (recording.objects, "object")):
        parts += [f"{len(names)} {kind}{'s' * (len(names) != 1)}"] if names else []
    if recording.reason:
        parts.append(f"ended early: {escape(recording.reason)}")
    return "; ".join(parts)


def _evidence(recording: Recording, scenario: Scenario, verdict: Verdict) -> str:
    rows = evidence(scenario, verdict.word, recording.prefix_length, recording.suffix_length)
    if not rows:
        return ""
    cells = [
        (escape(row.demand.owner or "all"), f"<code>{escape(str(row.demand).partition(': ')[2])}</code>",
         escape(row.meaning), f'<b class="{row.verdict}">{row.verdict}</b>', escape(row.seen))
        for row in rows
    ]  # fmt: skip
    head = ("member", "formula", "asks for", "verdict", "seen after steps")
    note = (
        "<p>Formulas are judged on the word that the recorded poses spell, with its last round repeated for ever.</p>"
    )
    return f"<h3>Formulas and their evidence</h3>{note}{_table(head, cells)}"


def _source(text: str) -> str:
    return f"<details><summary>Scenario file</summary><pre>{escape(text)}</pre></details>" if text else ""


def _steps(recording: Recording, figures: Mapping[str, Picture]) -> str:
    """A sheet of all, and each one larger below it."""
    parts = [*_pictures(figures, "steps")]
    large = [name for name in figures if name.startswith("step_")]
    for name, step in zip(large, recording.steps, strict=False):
        text = escape("; ".join(actions_words(step.actions)))
        picture = "".join(_pictures(figures, name))
        parts.append(f"<details><summary>Step {step.number + 1}: {text}</summary>{picture}</details>")
    if len(recording.steps) > len(large):
        parts.append(f"<p>The other {len(recording.steps) - len(large)} steps are in the folder {FIGURES}.</p>")
    return "\n".join(parts)


def _automaton(number: int, graph: AutomatonGraph, svg: str) -> str:
    states, edges = graph.num_states, len(graph.edges)
    count = f"{states} state{'s' * (states != 1)}, {edges} edge{'s' * (edges != 1)}"
    caption = f"{escape(graph.name)}: <code>{escape(spaced(graph.formula))}</code> ({count}) "
    caption += _links(f"automaton_{number}")
    picture = _image(svg, f"automaton of {graph.name}", "automaton")
    listed = ""
    if not graph.has_labels:
        rows = [(str(a), str(b), f"<code>{escape(label)}</code>") for a, b, label in graph.edges[:MOST_EDGES]]
        rest = f"<p>and {edges - MOST_EDGES} more</p>" if edges > MOST_EDGES else ""
        table = _table(("from", "to", "reads"), rows)
        listed = f"<details><summary>What its edges read</summary>{table}{rest}</details>"
    return f"<figure>{picture}<figcaption>{caption}</figcaption></figure>{listed}"


def _versions(recording: Recording) -> str:
    rows = [(escape(name), escape(version)) for name, version in recording.versions.items()]
    rows.append(("seed", str(recording.seed)))
    return _table(("what", "version"), rows)


def _pictures(figures: Mapping[str, Picture], *names: str) -> list[str]:
    return [_picture(name, figures[name]) for name in names if name in figures]


def _picture(name: str, picture: Picture) -> str:
    caption = f"<figcaption>{escape(picture.title)} {_links(name)}</figcaption>"
    return f"<figure>{_image(picture.svg, picture.title)}{caption}</figure>"


def _links(name: str) -> str:
    """To the files of a figure."""
    files = " ".join(f'<a href="{FIGURES}/{name}.{kind}">{kind.upper()}</a>' for kind in FORMATS)
    return f"<span>{files}</span>"


def _image(svg: str, text: str, kind: str = "") -> str:
    data = base64.b64encode(svg.encode()).decode("ascii")
    named = f' class="{kind}"' if kind else ""
    return f'<img{named} alt="{escape(text)}" src="data:image/svg+xml;base64,{data}">'


def _table(head: Iterable[str], rows: Iterable[Sequence[str]]) -> str:
    """Of cells that are HTML already; wide ones are scrolled."""
    top = "".join(f"<th>{cell}</th>" for cell in head)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class="wide"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def _anchor(title: str) -> str:
    return title.lower().replace(",", "").replace(" ", "-")
