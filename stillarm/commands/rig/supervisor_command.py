"""`stillarm supervisor`: frame capture and tracking."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--config", type=Path, required=True, metavar="FILE", help="configuration file (TOML)"
    )
    parser.add_argument(
        "--record-images", type=Path, metavar="REC", help="write images and samples to this file (MCAP)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the daemon."""
    from stillarm.progress import tell_terminal

    tell_terminal("supervisor: loads, and opens the camera; its log follows, Ctrl-C ends it")
    from stillarm.supervisor.daemon import run as run_supervisor

    run_supervisor(arguments.config, arguments.record_images)
    return 0
