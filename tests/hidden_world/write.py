"""`python -m tests.hidden_world.write --cause NAME|none --seed N --seconds 20 DIR`: one hidden recording as a bundle;
`--trial KIND:NUMBER --seed SEED`: a trial of a campaign. What was hidden is printed, and is in no file.
"""

import argparse
import json
from pathlib import Path

from tests.hidden_world.blind import KINDS, prepare
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
    parser.add_argument(
        "--trial", metavar="KIND:NUMBER", help=f"of a campaign's seed; KIND: {', '.join(KINDS)}"
    )
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    if given.trial is not None:
        kind, _, number = given.trial.partition(":")
        if kind not in KINDS or not number.isdigit():
            parser.error(f"--trial {given.trial}: write KIND:NUMBER, such as one:5; KIND: {', '.join(KINDS)}")
        print(json.dumps(prepare(kind, int(number), given.seed, given.folder), indent=1))
        return
    hidden = None if given.cause == "none" else given.cause
    case = draw_case(given.seed, hidden, given.size, given.seconds)
    write_bundle(make(case), given.folder)
    print(
        f"{given.folder}: "
        + ("; ".join(f"{e.name} {e.kind} {e.values}" for e in case.effects) or "nothing hidden")
    )


if __name__ == "__main__":
    main()
