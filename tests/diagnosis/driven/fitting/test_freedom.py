"""What sensors can show of a joint: by their kinds, and by what is known of their units."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.fitting.freedom import (
    STATED,
    shows_angle,
    shows_bending,
    shows_joint,
    shows_link,
)
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Kind, Output
from tests.fixtures.current_joint import STEP_S, drive_input, moved


def _fitted(kind: Kind, unit: bool = True, modes: int = 0, model: bool = False) -> DrivenFit:
    u = drive_input()
    seen = Output("x", kind, np.asarray(moved(u, 0.0, 0.0)[0]), unit, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_voltage_v", u, True, (seen,), {})
    numbers = {"gain": 1.0, "damping": 1.0} | ({STATED: 1.0} if model else {})
    fitted = fit(GreyBox(driven, irregular(driven.duration_s)), numbers, ())
    return replace(fitted, box=replace(fitted.box, modes=modes))


@pytest.mark.parametrize(
    ("kind", "known", "shown"),
    [
        ("position", {}, {shows_joint, shows_angle, shows_link}),
        ("velocity", {}, {shows_joint, shows_angle, shows_link}),
        ("velocity", {"unit": False}, {shows_joint, shows_link}),  # in volts
        ("velocity", {"unit": False, "model": True}, {shows_joint, shows_angle, shows_link}),
        ("acceleration", {}, {shows_joint, shows_link}),  # the arm does not bend
        ("acceleration", {"modes": 1}, {shows_bending, shows_link}),
        ("deflection", {"modes": 1}, {shows_bending, shows_link}),
    ],
)
def test_what_sensors_show(kind: Kind, known: dict[str, Any], shown: set[object]) -> None:
    fitted = _fitted(kind, **known)
    assert {one for one in (shows_joint, shows_angle, shows_bending, shows_link) if one(fitted)} == shown
