"""Every code block of the documentation does what its page says.

Blocks of one page run one after the other in a folder of their own: `python` in one namespace, `sh` line by line;
blocks with the title of a file are written, those with the title "output" are compared with what was printed (`...`
stands for anything).
"""

from __future__ import annotations

import contextlib
import doctest
import io
import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

from drake_ltl.cli import main, make_parser

_TITLE = re.compile(r'title="([^"]+)"')


@dataclass(frozen=True)
class Block:
    """One fenced block."""

    language: str
    title: str
    """What its page calls it: the name of a file, or `output` of the block before it."""
    text: str
    line: int
    """Of the page, from 1: where its first line of code is."""


def blocks(page: Path) -> list[Block]:
    """Those of a page."""
    found = []
    for token in MarkdownIt().parse(page.read_text(encoding="utf-8")):
        if token.type == "fence":
            language, _, rest = token.info.partition(" ")
            title = _TITLE.search(rest)
            found.append(Block(language, title[1] if title else "", token.content, token.map[0] + 2))
    return found


REPOSITORY = Path(__file__).parents[2]
PAGES = sorted(
    path
    for path in (*REPOSITORY.glob("*.md"), *(REPOSITORY / "docs").rglob("*.md"), *REPOSITORY.glob("examples/*.md"))
    if blocks(path)
)
ELSEWHERE = {
    "make": "each target is run by .ci/run",
    "pip": "would install",
    "python": "scripts have tests of their own",
    "git": "would change the repository",
    ".ci/run": "runs this test",
    "dask": "waits for ever",
    "source": "is for interactive shells",
    "cd": "says where to go",
    "pytest": "runs this test",
}
"""First words of commands that are not run here, and why."""
LANGUAGES = ("python", "sh", "yaml", "xml", "json", "text")


@pytest.mark.mission
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_blocks_do_what_the_page_says(page: Path, tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, object] = {"__name__": "__page__"}
    printed = ""
    for block in blocks(page):
        where = f"{page.name}, line {block.line}"
        assert block.language in LANGUAGES, f"{where}: nothing runs {block.language!r}"
        if block.title == "output":
            expect(block.text, printed, where)
        elif block.title:
            Path(block.title).write_text(block.text, encoding="utf-8")
        elif block.language in ("python", "sh"):
            printed = execute(block, page, namespace, where)


def execute(block: Block, page: Path, namespace: dict[str, object], where: str) -> str:
    """What it prints."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        if block.language == "python":
            lines = "\n" * (block.line - 1) + block.text  # so that tracebacks name the page's own lines
            exec(compile(lines, str(page), "exec"), namespace)
        else:
            for command in commands(block.text):
                run(command, where)
    return out.getvalue()


def commands(text: str) -> list[str]:
    """Lines with their continuations; comments say what the exit status is, if not 0."""
    return [line.strip() for line in text.replace("\\\n", " ").splitlines() if line.strip() and line[0] != "#"]


def run(command: str, where: str) -> None:
    words = shlex.split(command, comments=True)
    if words[0] in ELSEWHERE:
        return
    assert words[0] == "drake-ltl", f"{where}: nothing runs {words[0]!r}"
    status = re.search(r"# exit status (\d)", command)
    assert main(words[1:]) == int(status[1] if status else 0), f"{where}: {command}"


def expect(wanted: str, printed: str, where: str) -> None:
    checker, options = doctest.OutputChecker(), doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    printed = printed.replace("\N{NO-BREAK SPACE}", " ")
    pair = (re.sub("\N{BOX DRAWINGS LIGHT HORIZONTAL}+", "---", text) for text in (wanted, printed))  # of any length
    assert checker.check_output(*pair, options), f"{where}: this was printed instead:\n{printed}"


def test_whatever_looks_like_a_command_is_one():
    """Also where it takes too long to be run here, as in indented blocks: names of options and files are right."""
    checked = 0
    pages = [*REPOSITORY.glob("*.md"), *(REPOSITORY / "docs").rglob("*.md"), *REPOSITORY.glob("examples/*.md")]
    for page in pages:
        for line in page.read_text(encoding="utf-8").splitlines():
            if re.match(r"( {4}|)drake-ltl [a-z]", line) and not re.search(r"[\[|<]|\.\.\.", line):
                checked += 1
                make_parser().parse_args(shlex.split(line, comments=True)[1:])
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
