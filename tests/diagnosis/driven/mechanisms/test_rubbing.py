"""Measured rigs whose joint is driven: what is published of them is found. docs/measured-rigs.md has the figures."""

import numpy as np
import pytest

from stillarm.benchmarks.measured_rigs import QUANSER_FILE, quanser
from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.mechanisms.rubbing import anew_with_friction
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.starts.start import linear_start
from tests.conftest import DATA


def _held_out(fitted: DrivenFit, name: str) -> float:
    """Error on held-out blocks over the channel's deviation."""
    values = next(one.values for one in fitted.box.driven.outputs if one.name == name)
    return fitted.rms(name, True) / float(np.nanstd(values))


@pytest.mark.hardware_data
@pytest.mark.slow
@pytest.mark.skipif(not (DATA / QUANSER_FILE).is_file(), reason="../shared/data is not there")
def test_friction_takes_most_of_the_quanser_joints_current() -> None:
    """The joint's dry friction, as published, takes most of the current; nobody tells the program where it is."""
    driven = quanser(DATA)
    assert driven is not None
    start = linear_start(driven, irregular(driven.duration_s))
    fits = [
        fit(start.box, {**start.numbers, **one}, (*start.free, "coulomb"), start.states, steps=18)
        for one in anew_with_friction(start)
    ]
    best = max(fits, key=lambda one: float(one.whole.sum()))
    assert float(best.whole.sum()) - float(start.whole.sum()) > 5_000.0
    assert _held_out(best, "joint_position_rad") < 0.6 * _held_out(start, "joint_position_rad")
    assert _held_out(best, "joint_position_rad") < 0.022
    assert _held_out(best, "strain") < 0.5 * _held_out(start, "strain")
    # of the 0.23 A that the current varies by
    assert best.numbers["coulomb"] / best.numbers["gain"] == pytest.approx(0.16, abs=0.04)
