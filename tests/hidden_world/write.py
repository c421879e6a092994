"""`python -m tests.hidden_world.write --cause NAME|none --seed N --seconds 20 DIR`: one hidden recording as a bundle.

What was hidden is printed, and is in no file.
"""

import argparse
from pathlib import Path

from tests.hidden_world.bundle import write_bundle
from tests.hidden_world.draw import draw_case
from tests.hidden_world.effects import CAUSES, UNKNOWN
from tests.hidden_world.world import make


def main() -> None:
    """Draw, make and write."""
    parser = argparse.ArgumentParser(prog="python -m tests.hidden_world.write", description=__doc__)
    names = ["none", *CAUSES, *UNKNOWN]
    parser.add_argument("--cause", choices=names, default="none", metavar="NAME", help=", ".join(names))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--size", type=float, help="0 smallest, 1 largest (without: drawn)")
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    hidden = None if given.cause == "none" else given.cause
    case = draw_case(given.seed, hidden, given.size, given.seconds)
    write_bundle(make(case), given.folder)
    print(
        f"{given.folder}: "
        + ("; ".join(f"{e.name} {e.kind} {e.values}" for e in case.effects) or "nothing hidden")
    )


if __name__ == "__main__":
    main()
