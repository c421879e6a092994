"""`stillarm check`: finds what is wrong with the machine and the rig, and says what to do. It moves nothing."""

import argparse
from pathlib import Path

from stillarm.common.process.blas_threads import one_blas_thread


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--config", type=Path, required=True, metavar="FILE", help="configuration file (TOML)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print one line for each check. Returns 1 if a check fails."""
    one_blas_thread()  # as in the controller, whose step is measured
    from stillarm.preflight.verdict import Level
    from stillarm.preflight.walk import walk

    counts = dict.fromkeys(Level, 0)
    for verdict in walk(arguments.config):
        counts[verdict.level] += 1
        print(f"{verdict.where:<8}{verdict.level.value:<6}{verdict.text}", flush=True)
    failed = counts[Level.FAIL]
    print(
        f"{counts[Level.OK]} ok, {counts[Level.WARN]} warnings, {failed} failed: "
        + ("correct these first" if failed else "ready")
    )
    return 1 if failed else 0
