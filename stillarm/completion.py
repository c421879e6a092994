"""Shell completion, written from the command line's own parsers: `stillarm completion bash`, zsh or fish.

The script is static text. The shell starts no Python when it completes.
"""

import argparse
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Option:
    """An option of a command. names: `-o`, `--out`. choices: what may follow it. takes_value: False for a flag."""

    names: tuple[str, ...]
    help: str
    choices: tuple[str, ...]
    takes_value: bool


@dataclass(frozen=True)
class Command:
    """A command with its options. choices: of its positional arguments, such as the benchmarks' names."""

    name: str
    help: str
    options: tuple[Option, ...]
    choices: tuple[str, ...]


def command_of(name: str, help_text: str, parser: argparse.ArgumentParser) -> Command:
    """What a command's parser accepts."""
    actions = [one for one in parser._actions if one.help is not argparse.SUPPRESS]
    options = tuple(
        Option(tuple(one.option_strings), _line(one.help), _choices(one), one.nargs != 0)
        for one in actions
        if one.option_strings
    )
    positional = tuple(word for one in actions if not one.option_strings for word in _choices(one))
    return Command(name, help_text, options, positional)


def _choices(action: argparse.Action) -> tuple[str, ...]:
    return tuple(str(choice) for choice in action.choices or ())


def _line(text: str | None) -> str:
    return " ".join((text or "").replace("%%", "%").split())


def bash(commands: list[Command]) -> str:
    """For `source <(stillarm completion bash)`, or a file of bash-completion."""
    rows = []
    for command in commands:
        words = [name for option in command.options for name in option.names] + list(command.choices)
        rows.append(f"        {command.name}) words={shlex.quote(' '.join(words))} ;;")
    names = shlex.quote(" ".join(command.name for command in commands))
    return f"""\
_stillarm() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} words=""
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W {names} -- "$word"))
        return
    fi
    case ${{COMP_WORDS[1]}} in
{chr(10).join(rows)}
    esac
    COMPREPLY=($(compgen -W "$words" -- "$word"))
    case $word in
        -*) ;;
        *) COMPREPLY+=($(compgen -f -- "$word")) ;;
    esac
}}
complete -o filenames -F _stillarm stillarm
"""


def zsh(commands: list[Command]) -> str:
    """For `source <(stillarm completion zsh)` after compinit, or a file `_stillarm` in fpath."""
    described = "\n".join(f"        {shlex.quote(f'{one.name}:{one.help}')}" for one in commands)
    cases = []
    for command in commands:
        rows = [_zsh_option(name, option) for option in command.options for name in option.names]
        positional = f":argument:({' '.join(command.choices)})" if command.choices else ":file:_files"
        arguments = " ".join(shlex.quote(row) for row in [*rows, f"*{positional}"])
        cases.append(f"        {command.name}) _arguments {arguments} ;;")
    return f"""\
#compdef stillarm
_stillarm() {{
    local -a commands
    commands=(
{described}
    )
    if (( CURRENT == 2 )); then
        _describe command commands
        return
    fi
    local command=$words[2]
    shift words
    (( CURRENT-- ))
    case $command in
{chr(10).join(cases)}
    esac
}}
compdef _stillarm stillarm
"""


def _zsh_option(name: str, option: Option) -> str:
    text = option.help.replace("[", "(").replace("]", ")").replace(":", " -")
    if not option.takes_value:
        return f"{name}[{text}]"
    return (
        f"{name}[{text}]:value:({' '.join(option.choices)})"
        if option.choices
        else f"{name}[{text}]:value:_files"
    )


def fish(commands: list[Command]) -> str:
    """For `stillarm completion fish | source`, or ~/.config/fish/completions/stillarm.fish."""
    lines = []
    for command in commands:
        lines.append(
            f"complete -c stillarm -n __fish_use_subcommand -f -a {command.name} -d {_fish(command.help)}"
        )
        seen = f"complete -c stillarm -n {_fish(f'__fish_seen_subcommand_from {command.name}')}"
        lines += [f"{seen} {_fish_option(option)}" for option in command.options]
        lines += [f"{seen} -a {choice}" for choice in command.choices]
    return "\n".join(lines) + "\n"


def _fish_option(option: Option) -> str:
    words = [f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in option.names]
    if option.takes_value:
        words.append(f"-x -a {_fish(' '.join(option.choices))}" if option.choices else "-r")
    return " ".join([*words, f"-d {_fish(option.help)}"])


def _fish(text: str) -> str:
    """A word in single quotes, in which fish takes a backslash only before a quote or another."""
    escaped = text.replace("\\", "\\\\").replace("'", "\\'")
    return f"'{escaped}'"


SHELLS: Mapping[str, Callable[[list[Command]], str]] = {"bash": bash, "zsh": zsh, "fish": fish}
