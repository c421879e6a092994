"""`stillarm controller`: the 1 ms cycle."""

import argparse
from pathlib import Path

from stillarm.arguments import seconds
from stillarm.common.process.blas_threads import one_blas_thread


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--config", type=Path, required=True, metavar="FILE", help="configuration file (TOML)"
    )
    parser.add_argument("--record", type=Path, metavar="REC", help="write a recording (MCAP) to this file")
    parser.add_argument("--duration-s", type=seconds, metavar="S", help="stop after this many seconds")
    parser.add_argument(
        "--allow-non-realtime", action="store_true", help="run without the privileges that keep the deadlines"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the daemon."""
    one_blas_thread()
    from stillarm.progress import tell_terminal

    tell_terminal("controller: loads, and opens its devices; its log follows, Ctrl-C ends it")
    from stillarm.controller.loop.daemon import run as run_controller

    run_controller(
        arguments.config,
        arguments.record,
        arguments.duration_s,
        allow_non_realtime=arguments.allow_non_realtime,
    )
    return 0
