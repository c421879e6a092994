"""The force that a linear model lacks on each measured set of ../shared/data, over position and over velocity."""

import sys
from pathlib import Path

from matplotlib.axes import Axes
from style import BLUE, ORANGE, RED, new_pairs, save

from stillarm.benchmarks.measured_rigs import SETS
from stillarm.diagnosis.driven.diagnosed import DrivenResult
from stillarm.diagnosis.driven.foretold import identified_on
from stillarm.diagnosis.driven.mechanisms.missing import Curve
from stillarm.diagnosis.driven.page import missing_before

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
_BUDGET_S = 60.0


def draw(path: Path) -> None:
    """docs/images/measured-rigs.svg; needs ../shared/data."""
    rows: list[tuple[str, DrivenResult]] = []
    for name, read in SETS.items():
        driven = read(DATA)
        if driven is None:
            print(
                f"figures: measured-rigs: {DATA} holds no {name}; the picture stays as it was",
                file=sys.stderr,
            )
            return
        rows.append((name, identified_on(driven, _BUDGET_S)))
    figure, pairs = new_pairs(len(rows), 2.0 * len(rows))
    for (name, result), (left, right) in zip(rows, pairs, strict=True):
        found = missing_before(result)
        assert found is not None
        joint = not found.mode
        _panel(left, found.over_angle, "joint's angle, rad" if joint else f"deflection of mode {found.mode}")
        _panel(right, found.over_velocity, "velocity, rad/s" if joint else f"rate of mode {found.mode}")
        left.set_title(f"{name}: {_said(result)}", loc="left", fontsize=9)
    save(figure, path)


def _panel(axes: Axes, curve: Curve, over: str) -> None:
    axes.errorbar(curve.at, curve.mean, 2.0 * curve.error, color=BLUE, ecolor=ORANGE, lw=1.2, elinewidth=0.8)
    axes.axhline(0.0, color=RED, lw=0.6)
    axes.locator_params(axis="x", nbins=5)
    axes.set_xlabel(over)


def _said(result: DrivenResult) -> str:
    names = [one.form.cause for one in result.verdict.findings]
    return f"{result.verdict.verdict}{', ' if names else ''}{', '.join(names[:1])}"
