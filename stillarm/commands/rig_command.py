"""`stillarm rig`: the simulated rig in real time."""

import argparse
from pathlib import Path

from stillarm.arguments import seed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--config", type=Path, required=True, metavar="FILE", help="configuration file (TOML)"
    )
    parser.add_argument(
        "--truth", type=Path, metavar="REC", help="write what the rig truly does to this file (MCAP)"
    )
    parser.add_argument(
        "--scenario", metavar="NAME", help="scenario by name or file, in place of the configuration's"
    )
    parser.add_argument("--seed", type=seed, metavar="N", help="seed, in place of the configuration's")


def run(arguments: argparse.Namespace) -> int:
    """Run the daemon."""
    from simulation.rig import run as run_rig

    run_rig(arguments.config, arguments.truth, seed=arguments.seed, scenario=arguments.scenario)
    return 0
