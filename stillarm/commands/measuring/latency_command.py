"""`stillarm latency`: wake-up latency and computing time of the loop on this machine, compared with a floor."""

import argparse
import json
from pathlib import Path
from typing import Any

from stillarm.arguments import seconds
from stillarm.common.process.blas_threads import one_blas_thread
from stillarm.common.user_error import UserError, reason_of
from stillarm.progress import progress_bar


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--duration-s", type=seconds, default=20.0, metavar="S", help="duration of the measurement (20)"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result to this file")


def run(arguments: argparse.Namespace) -> int:
    """Measure and print."""
    one_blas_thread()
    from stillarm.benchmarks.loop.latency import run as measure

    with progress_bar("latency") as progress:
        result = measure(arguments.duration_s, progress)
    for missing in result["missing"]:
        print(f"not real-time: {missing}")
    print_latency(result)
    if arguments.json is not None:
        try:
            arguments.json.write_text(json.dumps(result, indent=2) + "\n")
        except OSError as error:
            raise UserError(
                f"--json {arguments.json}: {reason_of(error)}; name a file that can be written"
            ) from error
    return 0


def print_latency(result: dict[str, Any]) -> None:
    """Print a line for the loop, for each floor, and for the computing time."""
    print(f"{'us':<24}{'p50':>8}{'p99':>8}{'p99.9':>8}{'max':>9}{'missed':>8}{'cycles':>9}")
    names = {"loop": "loop wakes", "floor": "bare timer thread wakes", "cyclictest": "cyclictest wakes"}
    for key, name in names.items():
        if key in result:
            row = result[key]
            print(_line(name, row["wakeup_latency_us"]) + f"{row['deadline_misses']:>8}{row['cycles']:>9}")
    print(_line("loop computes", result["compute_us"]))


def _line(name: str, values: dict[str, float]) -> str:
    return f"{name:<24}" + "".join(
        f"{values[key]:>{width}.0f}" for key, width in (("p50", 8), ("p99", 8), ("p999", 8), ("max", 9))
    )
