"""`stillarm latency`: wake-up latency, computing time and sections of the loop on this machine, beside their floor."""

import argparse
import json
from collections.abc import Sequence
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
    print_sections(result["sections"])
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


def print_sections(sections: dict[str, Any]) -> None:
    """Print a line for each section of a cycle: duration, floor, calls and allocations."""
    print(
        f"\n{'a cycle, us':<16}{'p50':>8}{'p99':>8}{'floor p50':>11}{'floor p99':>11}{'calls':>8}{'allocations':>13}"
    )
    for name, row in sections.items():
        floor = row["floor_us"] or ("-", "-")
        kept = "-" if row["allocations"] is None else row["allocations"]
        print(f"{name:<16}" + _numbers((*row["us"], *floor, row["calls"], kept), (8, 8, 11, 11, 8, 13)))


def _numbers(values: Sequence[float | str], widths: Sequence[int]) -> str:
    return "".join(
        f"{value:>{width}}" if isinstance(value, str) else f"{value:>{width}.0f}"
        for value, width in zip(values, widths, strict=True)
    )


def _line(name: str, values: dict[str, float]) -> str:
    return f"{name:<24}" + "".join(
        f"{values[key]:>{width}.0f}" for key, width in (("p50", 8), ("p99", 8), ("p999", 8), ("max", 9))
    )
