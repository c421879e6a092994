"""`stillarm benchmark`: the documentation's tables, made afresh, beside floors and peers."""

import argparse
import json
from pathlib import Path
from typing import Any

BENCHMARKS = ("vision",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("name", choices=BENCHMARKS, metavar="NAME", help=f"one of: {', '.join(BENCHMARKS)}")
    parser.add_argument("--trials", type=int, default=3, metavar="N", help="trials of each row (3)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="seed of the first trial (0)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result to this file")


def run(arguments: argparse.Namespace) -> int:
    """Run the benchmark and print its table."""
    from benchmarks.vision import run as run_vision
    from stillarm.progress import progress_bar

    with progress_bar(f"benchmark {arguments.name}"):
        result = run_vision(arguments.trials, arguments.seed)
    print_rows(result["rows"])
    print(f"seed {arguments.seed}, {arguments.trials} trials")
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(result, indent=2) + "\n")
    return 0


def print_rows(rows: list[dict[str, Any]]) -> None:
    """A table with a column for each key of the first row."""
    keys = list(rows[0])
    texts = [[_text(row.get(key)) for key in keys] for row in rows]
    widths = [max(len(key), *(len(text[i]) for text in texts)) for i, key in enumerate(keys)]
    print("  ".join(key.ljust(width) for key, width in zip(keys, widths, strict=True)))
    for text in texts:
        print("  ".join(cell.ljust(width) for cell, width in zip(text, widths, strict=True)))


def _text(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
