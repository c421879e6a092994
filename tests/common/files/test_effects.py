"""The catalogue, the checks on [[effects]], and folding into the model."""

from math import isnan

import pytest

from stillarm.common.causes import CAUSES
from stillarm.common.files.effects import (
    FOLDED_CAUSES,
    declared,
    effect_of,
    not_used_by_controller,
)
from stillarm.common.files.model import Drive, Model

CUBIC = {"cause": "cubic_stiffness", "coefficient_per_m2": 100.0}


def test_the_catalogue_is_in_order_of_place_and_name() -> None:
    places = ["arm", "drive", "accelerometer", "camera", "timing"]
    order = [(places.index(cause.place), name) for name, cause in CAUSES.items()]
    assert order == sorted(order)
    assert {cause.place for cause in CAUSES.values()} == set(places)


@pytest.mark.parametrize("identifier", CAUSES)
def test_bounds_and_typical_sizes_agree(identifier: str) -> None:
    """Typical sizes lie within the bounds, to either side where signed; what is neutral is allowed."""
    for parameter in CAUSES[identifier].parameters:
        if parameter.kind in {"truth", "text"} or parameter.name == "onset_s":
            continue
        low, high = parameter.typical
        base = 0.0 if isnan(parameter.neutral) else parameter.neutral
        assert 0.0 <= low < high
        for sign in (1.0, -1.0) if parameter.signed else (1.0,):
            assert parameter.lowest <= base + sign * low <= parameter.highest
            assert parameter.lowest <= base + sign * high <= parameter.highest


def test_what_is_but_another_value_is_folded_and_the_rest_stays() -> None:
    model = Model(
        effects=[
            {"cause": "drive_dead_time", "dead_time_s": 0.03},
            CUBIC,
            {
                "cause": "second_bending_mode",
                "frequency_hz": 15.0,
                "damping_ratio": 0.02,
                "participation": -0.2,
            },
            {"cause": "accelerometer_clipping", "range_m_s2": 2.0},
            {"cause": "accelerometer_lag", "delay_s": 0.01},
            {"cause": "camera_tilt_coupling", "rotation_px_per_rad": -80.0},
            {"cause": "drive_lag", "bandwidth_hz": 7.0},
            {"cause": "drive_saturation", "max_velocity_rad_s": 0.1},
        ]
    )
    folded = declared(model)
    assert folded.effects == [CUBIC]
    assert folded.drive == Drive(dead_time_s=0.03, bandwidth_hz=7.0, max_velocity_rad_s=0.1)
    assert (folded.accelerometer.range_m_s2, folded.accelerometer.delay_s) == (2.0, 0.01)
    assert folded.camera.rotation_px_per_rad == -80.0
    assert [mode.frequency_hz for mode in folded.arm.modes] == [2.6, 15.0]
    assert declared(folded) == folded
    assert {str(effect["cause"]) for effect in model.effects} - {"cubic_stiffness"} == FOLDED_CAUSES
    assert declared(Model()) == Model()


def test_the_controller_says_what_it_makes_no_use_of() -> None:
    unused = not_used_by_controller(Model(effects=[CUBIC, {"cause": "drive_lag", "bandwidth_hz": 7.0}]))
    assert unused is not None and unused.endswith(": cubic_stiffness")
    assert not_used_by_controller(Model(effects=[{"cause": "drive_lag", "bandwidth_hz": 7.0}])) is None
    assert not_used_by_controller(Model(effects=[{"cause": "gear_backlash", "gap_rad": 0.01}])) is None
    assert effect_of(Model(), "cubic_stiffness") is None
