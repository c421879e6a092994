"""`python -m tests.hidden_world.rigs.write OUT --count N --seed S [--cause ID|none|unlisted|mixed] [--two]`: N
bundles with truth; `OUT --trial KIND:NUMBER --seed S`: the bundle of a blind trial, its truth beside it."""

import argparse
from pathlib import Path

from tests.hidden_world.rigs.blind import KINDS, drawn
from tests.hidden_world.rigs.bundle import write_bundle
from tests.hidden_world.rigs.case import Case, make
from tests.hidden_world.rigs.catalogue import ALL

_APART = 100_000


def main() -> None:
    """Draw, make and write OUT/case_0001 to case_N, or one trial to OUT. Other seeds share no case."""
    parser = argparse.ArgumentParser(prog="python -m tests.hidden_world.rigs.write", description=__doc__)
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--count", type=int, default=6, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument(
        "--cause", default="mixed", choices=["mixed", "none", "unlisted", "one", *ALL], metavar="ID"
    )
    parser.add_argument("--two", action="store_true", help="two effects in each")
    parser.add_argument(
        "--trial", metavar="KIND:NUMBER", help=f"of a campaign's seed; KIND: {', '.join(KINDS)}"
    )
    given = parser.parse_args()
    if given.trial is not None:
        kind, _, number = given.trial.partition(":")
        if kind not in KINDS or not number.isdigit():
            parser.error(f"--trial {given.trial}: write KIND:NUMBER, such as one:5; KIND: {', '.join(KINDS)}")
        _write(drawn(kind, int(number), given.seed), given.out)
        return
    for number in range(1, given.count + 1):
        case = make(given.seed * _APART + number, given.cause, given.two)
        _write(case, given.out / f"case_{number:04d}")


def _write(case: Case, folder: Path) -> None:
    write_bundle(case, folder)
    hidden = ", ".join(f"{e.cause} ({e.form}) {s:.2g}" for e, s in zip(case.effects, case.sizes, strict=True))
    print(f"{folder}: {case.expected}: {hidden or 'nothing'}", flush=True)


if __name__ == "__main__":
    main()
