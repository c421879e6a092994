"""The command `stillarm`: finds the subcommand, runs it, and prints a user's mistake in one line."""

import argparse
import importlib
import io
import signal
import sys
import warnings
from collections.abc import Sequence
from types import FrameType, ModuleType
from typing import NoReturn

from stillarm.common.user_error import UserError, reason_of
from stillarm.extras import missing_package, require

COMMANDS = {
    "demo": "run rig, supervisor and controller in real time, replay, and draw the figures",
    "controller": "the 1 ms cycle, as a daemon",
    "latency": "wake-up latency and computing time of this machine's loop, compared with a floor",
    "check": "preflight of the machine and the rig; moves nothing",
    "panel": "a page in the browser: the running loop, recordings, diagnosis, and an operator's commands",
    "operate": "arm, disarm, clear or stop a running controller",
    "supervisor": "frame capture and tracking, as a daemon",
    "rig": "the simulated rig that stands in for the hardware, as a daemon",
    "simulate": "rig, supervisor and controller in virtual time",
    "replay": "run the estimators on recorded data",
    "commission": "identify the rig's model file from small, supervised moves",
    "calibrate": "identify the model's parameters from a recording, with uncertainties",
    "diagnose": "find where the simulation differs from measured data, name the cause, extend the model",
    "causes": "print the causes that can be declared, hidden and named",
    "import": "read measured data (a CSV bundle, or a table of any format) into a recording",
    "track": "turn a video into the visual channel of a CSV bundle",
    "export": "write a recording as CSV or Parquet",
    "recover": "repair a cut recording",
    "benchmark": "regenerate the documentation's tables",
    "completion": "print the script by which bash, zsh or fish completes commands and options",
}

_FOLDERS = {
    "rig": ("demo", "controller", "supervisor", "rig", "check", "operate", "panel", "commission"),
    "recordings": (
        "simulate",
        "import",
        "track",
        "export",
        "recover",
        "replay",
        "calibrate",
        "diagnose",
        "causes",
    ),
    "measuring": ("latency", "benchmark"),
    "shell": ("completion",),
}
"""Where each command's file lies in stillarm/commands."""


class _Parser(argparse.ArgumentParser):
    """Reports a mistake in one line, with the command that explains the arguments."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {' '.join(message.split())}; see `{self.prog} --help`\n")


class _Version(argparse.Action):
    """Looks the version up only when it is asked for."""

    def __init__(self, option_strings: Sequence[str], dest: str, help: str) -> None:
        super().__init__(option_strings, dest, nargs=0, help=help)

    def __call__(self, parser: argparse.ArgumentParser, *arguments: object) -> NoReturn:
        from stillarm.common.recording.header import program_version

        parser.exit(0, f"stillarm {program_version()}\n")


def parser(command: str | None = None) -> argparse.ArgumentParser:
    """The command line's parser. Only the named command gets its arguments, so that the start stays fast."""
    top = _Parser(
        prog="stillarm", description="Stills the vibration of flexible robot arms through a late camera."
    )
    top.add_argument("--version", action=_Version, help="print the version, and exit")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, help_text in COMMANDS.items():
        sub = commands.add_parser(
            name, help=help_text, description=help_text[0].upper() + help_text[1:] + "."
        )
        if name == command:
            _module(name).add_arguments(sub)
    return top


def command_parser(command: str) -> argparse.ArgumentParser:
    """One command's parser with its arguments, such as completion and the reference pages read. Raises KeyError."""
    top = parser(command)
    (commands,) = (one for one in top._actions if isinstance(one, argparse._SubParsersAction))
    found: argparse.ArgumentParser = commands.choices[command]
    return found


def _module(command: str) -> ModuleType:
    folder = next(folder for folder, commands in _FOLDERS.items() if command in commands)
    return importlib.import_module(f"stillarm.commands.{folder}.{command}_command")


def _run(parsed: argparse.Namespace) -> int:
    """Run the command. Raises UserError, too, where a package of an extra is missing."""
    require(parsed.command)
    try:
        status: int = _module(parsed.command).run(parsed)
    except ModuleNotFoundError as error:
        raise missing_package(error) or error from None
    return status


def _interrupt(number: int, frame: FrameType | None) -> NoReturn:
    raise KeyboardInterrupt


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    # SIGINT too: a shell that starts a command in the background (`&`) sets it to be ignored.
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, _interrupt)
    if not sys.warnoptions:  # standard error is for users' mistakes; developers can use python -W
        warnings.simplefilter("ignore")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # into a pipe, too, a line arrives when it is printed
    words = sys.argv[1:] if arguments is None else arguments
    command = next((word for word in words if word in COMMANDS), None)
    try:
        parsed = parser(command).parse_args(words)
        return _run(parsed)
    except UserError as error:
        print(f"stillarm: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:  # Ctrl-C or SIGTERM; the `finally` clauses have stopped what was started
        print("stillarm: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        return 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename is not None else ""
        print(f"stillarm: {where}{reason_of(error)}; correct that, and start again", file=sys.stderr)
        return 1
    except MemoryError:
        print("stillarm: not enough memory; free some, or take a shorter recording", file=sys.stderr)
        return 1
