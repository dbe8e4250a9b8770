"""Scripts for the completion of bash, zsh and fish, made from an argparse parser with commands."""

from __future__ import annotations

import argparse
import shlex
from dataclasses import dataclass

PROGRAM = "drake-ltl"
ENDINGS = {"FILE": ("yaml", "yml"), "RECORDING": ("npz",)}
"""Of the files that are asked for by these names."""
NO_FILES = ("N", "S", "J", "K", "P", "ADDRESS")
"""Values that are numbers, or addresses."""


@dataclass(frozen=True)
class _Argument:
    """An option, or what stands without one."""

    flags: tuple[str, ...]
    """`--json`, or nothing."""
    help: str
    value: str | None
    """What its value is called; None if it takes none."""
    choices: tuple[str, ...]

    @property
    def takes_file(self) -> bool:
        return self.value is not None and not self.choices and self.value not in NO_FILES


@dataclass(frozen=True)
class _Command:
    name: str
    help: str
    options: tuple[_Argument, ...]
    positional: _Argument | None


def script(shell: str, parser: argparse.ArgumentParser) -> str:
    """The script for `bash`, `zsh` or `fish`."""
    commands, options = _commands(parser), _arguments(parser)[0]
    return {"bash": _bash, "zsh": _zsh, "fish": _fish}[shell](commands, options)


def _commands(parser: argparse.ArgumentParser) -> list[_Command]:
    (subparsers,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    helps = {choice.dest: choice.help or "" for choice in subparsers._choices_actions}
    commands = []
    for name, own in subparsers.choices.items():
        options, positional = _arguments(own)
        commands.append(_Command(name, helps[name], options, positional))
    return commands


def _arguments(parser: argparse.ArgumentParser) -> tuple[tuple[_Argument, ...], _Argument | None]:
    """The options of a parser, and what may stand without one (at most one thing, with any command)."""
    found = [
        _Argument(
            tuple(action.option_strings),
            action.help or "",
            None if action.nargs == 0 else str(action.metavar or action.dest),
            tuple(map(str, action.choices or ())),
        )
        for action in parser._actions
        if not isinstance(action, argparse._SubParsersAction)
    ]
    return tuple(one for one in found if one.flags), next((one for one in found if not one.flags), None)


def _flags(options: tuple[_Argument, ...]) -> str:
    return " ".join(flag for option in options for flag in option.flags)


_BASH = r"""# Completion of drake-ltl for bash.
_drake_ltl_files() {{
    local word left_out
    compopt -o filenames 2>/dev/null || :  # fails where it is not called by a completion
    while IFS= read -r word; do COMPREPLY+=("$word"); done < <(
        compgen -d -- "$cur"
        for left_out in "$@"; do compgen -f -X "$left_out" -- "$cur"; done
    )
}}
_drake_ltl() {{
    local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} command='' i
    COMPREPLY=()
    for ((i = 1; i < COMP_CWORD; i++)); do
        if [[ ${{COMP_WORDS[i]}} != -* ]]; then command=${{COMP_WORDS[i]}}; break; fi
    done
    case "$command $prev" in
{values}
    esac
    case "$command $cur" in
{options}
    esac
    case "$command" in
{positionals}
    esac
}}
complete -F _drake_ltl drake-ltl"""


def _bash(commands: list[_Command], options: tuple[_Argument, ...]) -> str:
    names = " ".join(command.name for command in commands)
    values = [
        f"        '{command.name} {flag}') {_bash_value(option)} return ;;"
        for command in commands
        for option in command.options
        if option.value is not None
        for flag in option.flags
    ]
    given = [("", options), *((command.name, command.options) for command in commands)]
    flags = [f"        '{name} '-*) {_bash_words(_flags(own))} return ;;" for name, own in given]
    positionals = [f"        '') {_bash_words(names)} ;;"]
    positionals += [f"        {c.name}) {_bash_value(c.positional)} ;;" for c in commands if c.positional is not None]
    return _BASH.format(values="\n".join(values), options="\n".join(flags), positionals="\n".join(positionals))


def _bash_words(words: str) -> str:
    return f"COMPREPLY=($(compgen -W '{words}' -- \"$cur\"));"


def _bash_value(argument: _Argument) -> str:
    if argument.choices:
        return _bash_words(" ".join(argument.choices))
    if not argument.takes_file:
        return ""
    endings = ENDINGS.get(argument.value or "", ())
    patterns = [f"'!*.{ending}'" for ending in endings] or ["''"]
    return f"_drake_ltl_files {' '.join(patterns)};"


def _zsh(commands: list[_Command], options: tuple[_Argument, ...]) -> str:
    lines = ["#compdef drake-ltl", "_drake_ltl() {", "    local -a commands", "    commands=("]
    lines += [f"        {shlex.quote(command.name + ':' + command.help.replace(':', ''))}" for command in commands]
    lines += ["    )", "    if (( CURRENT == 2 )); then"]
    lines += [f"        _arguments {' '.join(_zsh_option(option) for option in options)}"]
    lines += ["        _describe -t commands command commands", "        return", "    fi"]
    lines += ["    shift words", "    (( CURRENT-- ))", '    case "$words[1]" in']
    for command in commands:
        specs = [_zsh_option(option) for option in command.options]
        specs += [shlex.quote("1" + _zsh_value(command.positional))] if command.positional else []
        lines += [f"        {command.name})", "            _arguments \\"]
        lines += [" \\\n".join(f"                {spec}" for spec in specs), "            ;;"]
    return "\n".join([*lines, "    esac", "}", '_drake_ltl "$@"'])


def _zsh_option(option: _Argument) -> str:
    text = option.help.replace("[", "(").replace("]", ")").replace(":", "")
    value = "" if option.value is None else _zsh_value(option)
    return " ".join(shlex.quote(f"{flag}[{text}]{value}") for flag in option.flags)


def _zsh_value(argument: _Argument) -> str:
    if argument.choices:
        return f":{argument.value}:({' '.join(argument.choices)})"
    if not argument.takes_file:
        return f":{argument.value}: "
    endings = ENDINGS.get(argument.value or "")
    return f":{argument.value}:_files" + (f' -g "*.({"|".join(endings)})"' if endings else "")


def _fish(commands: list[_Command], options: tuple[_Argument, ...]) -> str:
    lines = ["# Completion of drake-ltl for fish.", f"complete -c {PROGRAM} -f"]
    for option in options:
        lines.append(
            f"complete -c {PROGRAM} -n __fish_use_subcommand {_fish_flags(option)} -d {_fish_text(option.help)}"
        )
    for command in commands:
        seen = f"complete -c {PROGRAM} -n '__fish_seen_subcommand_from {command.name}'"
        lines.append(f"complete -c {PROGRAM} -n __fish_use_subcommand -a {command.name} -d {_fish_text(command.help)}")
        for option in command.options:
            lines.append(f"{seen} {_fish_flags(option)} {_fish_value(option)}-d {_fish_text(option.help)}")
        if command.positional is not None:
            lines.append(f"{seen} {_fish_value(command.positional, flag=False)}".rstrip())
    return "\n".join(lines)


def _fish_flags(option: _Argument) -> str:
    return " ".join(f"-l {flag[2:]}" if flag.startswith("--") else f"-s {flag[1:]}" for flag in option.flags)


def _fish_value(argument: _Argument, *, flag: bool = True) -> str:
    """Options of `complete` for a value, with a space after them."""
    if argument.value is None:
        return ""
    if argument.choices:
        return f"{'-x ' if flag else ''}-a '{' '.join(argument.choices)}' "
    if argument.takes_file:
        return "-r -F " if flag else "-F "
    return "-x "


def _fish_text(text: str) -> str:
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
