"""`python -m tests.hidden_world.driven.write OUT --count N --seed S [--none K] [--cause ID]`: cases with truth."""

import argparse
from pathlib import Path

from tests.hidden_world.driven.case import make
from tests.hidden_world.driven.effects import CAUSES
from tests.hidden_world.driven.files import write_case
from tests.hidden_world.driven.rig import luck

_APART = 100_000


def planned(count: int, seed: int, none: int = 0, cause: str = "") -> list[str]:
    """The causes of the cases: each as often as the others, in drawn order, and `none` cases without."""
    chance = luck(seed, 2)
    turns = [str(c) for _ in range(count // len(CAUSES) + 1) for c in chance.permutation(list(CAUSES))]
    hidden = [cause] * count if cause else turns[:count]
    return [str(c) for c in chance.permutation([*hidden, *["none"] * none])]


def main() -> None:
    """Draw, make and write OUT/case_0001 to case_N+K. Other seeds share no case."""
    parser = argparse.ArgumentParser(prog="python -m tests.hidden_world.driven.write", description=__doc__)
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--count", type=int, default=6, metavar="N", help="cases with a hidden cause")
    parser.add_argument("--none", type=int, default=0, metavar="K", help="cases without one")
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument("--cause", default="", choices=["", *CAUSES], metavar="ID", help="the same in each")
    given = parser.parse_args()
    plan = planned(given.count, given.seed, given.none, given.cause)
    for number, cause in enumerate(plan, start=1):
        case = make(given.seed * _APART + number, cause)
        folder = given.out / f"case_{number:04d}"
        write_case(case, folder)
        form = f" ({case.effect.form}), {case.shows:.3g} of the noise" if case.effect else ""
        print(f"{number} of {len(plan)}: {folder}: {cause}{form}", flush=True)


if __name__ == "__main__":
    main()
