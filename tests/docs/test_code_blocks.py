"""Every code block of the documentation does what its page says.

Blocks of one page run one after the other in a folder of their own that is laid out like a checkout. `python` runs in
one namespace; `sh` line by line in this process where all lines are of `drake-ltl`, else as a script of bash. Blocks
with the title of a file are written; those with the title "output" are compared with what was printed (`...` stands for
anything). `yaml` without a title is a part of an example. `text` without one is no code: a formula, a table, a message.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from markdown_it import MarkdownIt
from markdown_it.token import Token

from drake_ltl.cli import main, make_parser

_TITLE = re.compile(r'title="([^"]+)"')
REPOSITORY = Path(__file__).parents[2]
DOCUMENTS = sorted([*REPOSITORY.glob("*.md"), *(REPOSITORY / "docs").rglob("*.md"), *REPOSITORY.glob("examples/*.md")])
LONG = ("results.md", "soak.md", "sweep.md")
"""Pages whose blocks take so long that CI runs them in a step of their own: `pytest -m long`."""
LANGUAGES = ("python", "sh", "yaml", "xml", "json", "text")
COMMANDS = "commands"
"""Title of a list of all commands with their options."""


@dataclass(frozen=True)
class Block:
    """One fenced block."""

    language: str
    title: str
    """What its page calls it: the name of a file, or `output` of the block before it."""
    text: str
    line: int
    """Of the page, from 1: where its first line of code is."""


def tokens(page: Path) -> list[Token]:
    """What a page consists of."""
    return MarkdownIt().parse(page.read_text(encoding="utf-8"))


def blocks(page: Path) -> list[Block]:
    """Those of a page."""
    found = []
    for token in tokens(page):
        if token.type == "fence":
            language, _, rest = token.info.partition(" ")
            title = _TITLE.search(rest)
            found.append(Block(language, title[1] if title else "", token.content, token.map[0] + 2))
    return found


def marked(page: Path) -> object:
    """The page as a parameter of a test."""
    marks = [pytest.mark.mission, *([pytest.mark.long] if page.name in LONG else [])]
    return pytest.param(page, marks=marks, id=str(page.relative_to(REPOSITORY)))


@pytest.mark.parametrize("page", [marked(page) for page in DOCUMENTS if blocks(page)])
def test_blocks_do_what_the_page_says(page: Path, tmp_path: Path, monkeypatch):
    lay_out(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]))
    namespace: dict[str, object] = {"__name__": "__page__"}
    printed = ""
    for block in blocks(page):
        where = f"{page.name}, line {block.line}"
        if block.title == "output":
            expect(block.text, printed, where)
        elif block.title == COMMANDS:
            continue  # test_all_commands_are_listed
        elif block.title:
            Path(block.title).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            printed = executed(block, page, namespace)
        elif block.language == "sh":
            printed = ran(block, where)
        elif block.language != "text":
            assert is_part_of_an_example(block.text), f"{where}: stands in no example, and has no title"


def lay_out(folder: Path) -> None:
    """What a checkout has and blocks make use of; pages are copies, for some blocks write them anew."""
    for name in ("examples", "benchmarks"):
        (folder / name).symlink_to(REPOSITORY / name)
    (folder / ".venv").symlink_to(sys.prefix)
    (folder / "docs").mkdir()
    for page in (REPOSITORY / "docs").glob("*.md"):
        shutil.copy(page, folder / "docs")


def executed(block: Block, page: Path, namespace: dict[str, object]) -> str:
    """What Python prints."""
    lines = "\n" * (block.line - 1) + block.text  # so that tracebacks name the page's own lines
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        exec(compile(lines, str(page), "exec"), namespace)
    return out.getvalue()


def ran(block: Block, where: str) -> str:
    """What commands print. Comments say what the exit status is, if not 0. Targets of make are steps of CI."""
    lines = commands(block.text)
    script = [line for line in lines if line.split()[0] != "make"]
    for line in lines:
        assert line in script or line.partition("#")[0].strip() in ci_steps(), f"{where}: CI does not run {line!r}"
    if any(line.split()[0] != "drake-ltl" for line in script):
        return ran_by_bash(script, where)
    out = io.StringIO()
    for line in script:
        status = re.search(r"# exit status (\d)", line)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            found = main(shlex.split(line, comments=True)[1:])
        assert found == int(status[1] if status else 0), f"{where}: {line}\n{out.getvalue()}"
    return out.getvalue()


def ran_by_bash(script: list[str], where: str) -> str:
    if any(line.startswith("dask ") for line in script) and "CI" not in os.environ:
        pytest.importorskip("distributed", reason="the extra `dask` is not installed")
    command = ["bash", "-eo", "pipefail", "-c", "\n".join(script)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    assert done.returncode == 0, f"{where}:\n{done.stdout}"
    return done.stdout


def ci_steps() -> list[str]:
    """Lines of what CI runs, without comments."""
    text = (REPOSITORY / ".ci" / "run").read_text(encoding="utf-8")
    return [line.partition("#")[0].strip() for line in text.splitlines()]


def commands(text: str) -> list[str]:
    """Lines with their continuations, without those that are only comments."""
    return [line.strip() for line in text.replace("\\\n", " ").splitlines() if line.strip() and line[0] != "#"]


def is_part_of_an_example(text: str) -> bool:
    """Whatever the margin."""
    lines = [line.strip() for line in text.splitlines()]
    for path in REPOSITORY.glob("examples/*.yaml"):
        example = [line.strip() for line in path.read_text(encoding="utf-8").splitlines()]
        if any(example[start : start + len(lines)] == lines for start in range(len(example))):
            return True
    return False


def expect(wanted: str, printed: str, where: str) -> None:
    checker, options = doctest.OutputChecker(), doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    printed = printed.replace("\N{NO-BREAK SPACE}", " ")
    pair = (re.sub("\N{BOX DRAWINGS LIGHT HORIZONTAL}+", "---", text) for text in (wanted, printed))  # of any length
    assert checker.check_output(*pair, options), f"{where}: this was printed instead:\n{printed}"


@pytest.mark.parametrize("page", DOCUMENTS, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_every_block_says_what_it_is(page):
    """Indented blocks cannot, and nobody runs them."""
    indented = [token.map[0] + 1 for token in tokens(page) if token.type == "code_block"]
    assert not indented, f"{page.name}: indented blocks in lines {indented}; put them into fences"
    for block in blocks(page):
        assert block.language in LANGUAGES, f"{page.name}, line {block.line}: nothing runs {block.language!r}"


def test_all_commands_are_listed():
    """With all options, but for those that every command has."""
    (listed,) = [block for block in blocks(REPOSITORY / "README.md") if block.title == COMMANDS]
    entries = re.split(r"^drake-ltl ", listed.text, flags=re.MULTILINE)[1:]
    parsers = next(action.choices for action in make_parser()._actions if action.choices)
    assert [entry.split()[0] for entry in entries] == list(parsers)
    for entry in entries:
        own = {flag for action in parsers[entry.split()[0]]._actions for flag in action.option_strings}
        shown = set(re.findall(r"--[a-z-]+", re.sub(r" # .*", "", entry)))
        assert shown == own - {"-h", "--help", "--no-color", "--allow-models"}, entry


def test_commands_in_sentences_are_right():
    """As far as names of commands and options go."""
    checked = 0
    for page in DOCUMENTS:
        for command in re.findall(r"`drake-ltl ([a-z]+ [^`\[|<]*)`", page.read_text(encoding="utf-8")):
            checked += 1
            make_parser().parse_args(shlex.split(command.replace("FILE", "patrol").replace(" N", " 3")))
    assert checked > 5


@pytest.mark.parametrize(
    ("wanted", "printed", "equal"), [("a\n...\nd", "a\nb\nd\n", True), ("a", "b\n", False), ("a b", "a   b\n", True)]
)
def test_outputs_are_compared(wanted, printed, equal):
    with contextlib.nullcontext() if equal else pytest.raises(AssertionError):
        expect(wanted, printed, "here")


def test_blocks_are_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text('Say\n\n```yaml title="a.yaml"\na: 1\n```\n\n- so\n\n  ```sh\n  drake-ltl check a\n  ```\n')
    assert blocks(page) == [Block("yaml", "a.yaml", "a: 1\n", 4), Block("sh", "", "drake-ltl check a\n", 10)]


def test_parts_of_examples():
    assert is_part_of_an_example("centre: [-8, 0, 0]") is False
    first = (REPOSITORY / "examples" / "patrol.yaml").read_text(encoding="utf-8").splitlines()[2:5]
    assert is_part_of_an_example("\n".join(f"    {line}" for line in first))
