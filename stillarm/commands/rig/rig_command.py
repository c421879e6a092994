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
        "--truth", type=Path, metavar="REC", help="write the rig's true motion to this file (MCAP)"
    )
    parser.add_argument(
        "--scenario", metavar="NAME", help="scenario by name or file, in place of the configuration's"
    )
    parser.add_argument(
        "--accelerometer",
        metavar="NAME",
        help="emulate this one in place of the configuration's. Name it as the controller's accelerometer.driver too, "
        "with the configuration's bus or port, or memory:rig-i2c or pty:rig-accelerometer",
    )
    parser.add_argument("--seed", type=seed, metavar="N", help="seed, in place of the configuration's")


def run(arguments: argparse.Namespace) -> int:
    """Run the daemon."""
    from stillarm.progress import tell_terminal

    tell_terminal("rig: the simulated rig loads; its log follows, Ctrl-C ends it")
    from stillarm.simulation.rig.rig import run as run_rig

    run_rig(
        arguments.config,
        arguments.truth,
        seed=arguments.seed,
        scenario=arguments.scenario,
        accelerometer=arguments.accelerometer,
    )
    return 0
