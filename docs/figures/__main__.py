"""`make figures`: draws every picture of the documentation that no other command draws, into docs/images/.

`python docs/figures NAME ...` draws some. The seeds are fixed, so that the pictures come out the same again.
measured-rigs is drawn from ../shared/data, and stays as it is without. docs/overview.png is the demo's;
docs/panel-*.png are docs/screenshots'; docs/diagnosis-*.png are `stillarm benchmark diagnosis`'s.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import bound
import equations
import fused
import late_images
import measured_rigs
import phase
import stilled
import verdict
import wiring

IMAGES = Path(__file__).resolve().parents[1] / "images"
FIGURES: dict[str, Callable[[Path], None]] = {
    "bound": bound.draw,
    "equations": equations.draw,
    "fused": fused.draw,
    "late-images": late_images.draw,
    "measured-rigs": measured_rigs.draw,
    "phase": phase.draw,
    "stilled": stilled.draw,
    "verdict": verdict.draw,
    "wiring": wiring.draw,
}
"""What draws docs/images/NAME.svg."""


def main(names: list[str]) -> int:
    """Draw the named figures, or all."""
    if unknown := [name for name in names if name not in FIGURES]:
        print(f"figures: no figure {unknown[0]}; there are {', '.join(FIGURES)}", file=sys.stderr)
        return 1
    IMAGES.mkdir(exist_ok=True)
    for name in names or FIGURES:
        path = IMAGES / f"{name}.svg"
        FIGURES[name](path)
        print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
