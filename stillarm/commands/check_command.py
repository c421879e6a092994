"""`stillarm check`: what is wrong with the machine and the rig, and what to do; it moves nothing."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--config", type=Path, required=True, metavar="FILE", help="configuration file (TOML)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print one line for each check; 1 if one fails."""
    from stillarm.preflight.verdict import Level
    from stillarm.preflight.walk import walk

    counts = dict.fromkeys(Level, 0)
    for verdict in walk(arguments.config):
        counts[verdict.level] += 1
        print(f"{verdict.where:<8}{verdict.level.value:<6}{verdict.text}", flush=True)
    failed = counts[Level.FAIL]
    print(
        f"{counts[Level.OK]} ok, {counts[Level.WARN]} warnings, {failed} failed: "
        + ("mend these first" if failed else "ready")
    )
    return 1 if failed else 0
