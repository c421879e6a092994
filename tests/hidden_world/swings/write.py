"""`python -m tests.hidden_world.swings.write OUT --count N --seed S [--kind KIND] [--plain]`: N bundles with truth."""

import argparse
from pathlib import Path

from tests.hidden_world.swings.bundle import words, write_bundle
from tests.hidden_world.swings.draw import KINDS, draw
from tests.hidden_world.swings.plain import draw_plain
from tests.hidden_world.swings.sensors import make


def main() -> None:
    """Draw, make and write: OUT/KIND_SEED for seeds S to S + N - 1."""
    parser = argparse.ArgumentParser(prog="python -m tests.hidden_world.swings.write", description=__doc__)
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--count", type=int, default=6, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument("--kind", choices=KINDS, help="how the first motion comes about (they take turns)")
    parser.add_argument("--plain", action="store_true", help="rigs without stalls, losses, dead sensors")
    given = parser.parse_args()
    for seed in range(given.seed, given.seed + given.count):
        case = (draw_plain if given.plain else draw)(seed, given.kind)
        folder = given.out / f"{case.kind}_{seed}"
        write_bundle(make(case), folder)
        print(f"{folder}: {words(case)}", flush=True)


if __name__ == "__main__":
    main()
