"""Commands in process, and scenario files to give them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from drake_ltl.cli import main


@pytest.fixture
def drake_ltl(capsys) -> Callable[..., SimpleNamespace]:
    """drake_ltl("plan", path, ...): exit status, stdout and stderr of the command."""

    def run(*arguments: object) -> SimpleNamespace:
        capsys.readouterr()
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as usage:  # argparse ends a process that is called wrongly
            status = usage.code
        captured = capsys.readouterr()
        assert "Traceback" not in captured.err + captured.out
        return SimpleNamespace(status=status, out=captured.out, err=captured.err)

    return run


@pytest.fixture
def shuttle_file(tmp_path, shuttle_text) -> Path:
    path = tmp_path / "shuttle.yaml"
    path.write_text(shuttle_text, encoding="utf-8")
    return path


@pytest.fixture
def changed(tmp_path, examples) -> Callable[[dict[str, str]], Path]:
    """changed({old: new}, example="case_ii.yaml"): an example with some text replaced."""

    def make(changes: dict[str, str], example: str = "case_ii.yaml") -> Path:
        text = (examples / example).read_text(encoding="utf-8")
        for old, new in changes.items():
            assert old in text, old
            text = text.replace(old, new)
        path = tmp_path / example
        path.write_text(text, encoding="utf-8")
        return path

    return make
