"""reference/commands.md, from the command line's parsers."""

import argparse

from stillarm.extras import NEEDED_BY
from stillarm.main import COMMANDS, command_parser

_HEAD = """# Commands

Every command has `--help`. The exit status is 0 only on success; an error is one line on standard error.
This page is made from the parsers that the commands use.

"""


def page() -> str:
    """The whole page."""
    return _HEAD + "\n".join(section(name) for name in COMMANDS)


def section(name: str) -> str:
    """One command: usage, arguments, and the extras that it needs."""
    parser = command_parser(name)
    text = COMMANDS[name]
    parser.formatter_class = lambda prog: argparse.HelpFormatter(prog, width=100)
    usage = parser.format_usage().removeprefix("usage: ")
    lines = [
        f"## {name}",
        "",
        f"{text[0].upper()}{text[1:]}.",
        "",
        *(f"    {row}" for row in usage.splitlines()),
    ]
    if extras := NEEDED_BY.get(name):
        lines += ["", f"Needs `pip install 'stillarm[{','.join(extras)}]'`."]
    lines += ["", "| argument | meaning |", "|---|---|"]
    lines += [
        f"| {_shown(one)} | {_cell(one.help)} |"
        for one in parser._actions
        if "--help" not in one.option_strings
    ]
    return "\n".join(lines) + "\n"


def _shown(action: argparse.Action) -> str:
    value = str(action.metavar or action.dest.upper())
    if not action.option_strings:
        return f"`{value}`"
    names = ", ".join(f"`{name}`" for name in action.option_strings)
    return names if action.nargs == 0 else f"{names} `{value}`"


def _cell(text: str | None) -> str:
    return " ".join((text or "").replace("%%", "%").split()).replace("|", "\\|")
