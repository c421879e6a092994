"""`stillarm completion`: prints the script by which a shell completes commands and options."""

import argparse

from stillarm.completion import SHELLS, command_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("shell", choices=tuple(SHELLS), help="the shell that is to complete")


def run(arguments: argparse.Namespace) -> int:
    """Print the script."""
    from stillarm.main import COMMANDS, command_parser

    commands = [command_of(name, text, command_parser(name)) for name, text in COMMANDS.items()]
    print(SHELLS[arguments.shell](commands), end="")
    return 0
