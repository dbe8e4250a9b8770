"""Without the fuzzer there is one clear line, and no failure."""

from __future__ import annotations

import importlib.util
import sys


def test_the_fuzzer_is_missing(program, monkeypatch, capsys):
    fuzz = program("fuzz")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(sys, "argv", ["fuzz.py"])
    assert fuzz.main() is None
    (line,) = capsys.readouterr().out.splitlines()
    assert "pip install 'drake-ltl[fuzz]'" in line
