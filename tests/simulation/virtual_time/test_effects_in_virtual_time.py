"""Every cause through `simulate`: it shows where it should, and a model without effects runs as it always did."""

from math import isnan
from typing import Any

import msgspec
import pytest

from stillarm.common.causes import CAUSES
from stillarm.common.files.scenario import Window
from stillarm.controller.replay.replay import RecordedRun, compare_with_live
from stillarm.simulation.virtual_time.virtual_time import VirtualRun, simulate
from tests.fixtures.virtual_rows import CONFIGURATION, MODEL, SCENARIO, Rows, plain_rows, run, said

pytestmark = pytest.mark.slow

SIZES: dict[str, dict[str, Any]] = {
    "drive_deadband": {"deadband_rad_s": 0.02},
    "drive_saturation": {"max_velocity_rad_s": 0.05},
    "impulse_noise": {"rate_hz": 20.0, "amplitude_m_s2": 10.0},
    "delay_bursts": {"rate_hz": 5.0, "duration_s": 0.2, "delay_s": 0.05},
}


def clear(identifier: str) -> dict[str, Any]:
    """An effect of a size that shows within two seconds."""
    effect: dict[str, Any] = {"cause": identifier}
    for parameter in CAUSES[identifier].parameters:
        if parameter.default is None:
            shown = parameter.typical[1]
            effect[parameter.name] = (
                1.0
                if parameter.name == "onset_s"
                else shown + (0.0 if isnan(parameter.neutral) else parameter.neutral)
            )
    return effect | SIZES.get(identifier, {})


# Worked out by the program as it was before it knew any effect: cycle -> acceleration, theta, deflection, s''.
BEFORE = {
    500: (0.430956298828125, 0.0, -0.0005899979353114086, 0.18324025739399402),
    1234: (-1.70467158203125, 0.01985422528455624, 0.003965785490746426, -1.048743265733659),
    1999: (-3.6008792968749996, 0.04500000000000024, 0.013695229350445636, -3.699779890140643),
}
FRAMES_BEFORE = {
    10: (10, 0.26, 0.008954247111186342),
    60: (60, 1.026, 4.009950745647639),
    110: (110, 1.795, -72.2571878945046),
}


def test_a_model_without_effects_runs_as_before_there_were_any() -> None:
    """As far as the processor's own mathematics allow; a changed draw is off in the first digit."""
    fast, frames, state = plain_rows()["/fast"], plain_rows()["/frames"], plain_rows()["/truth/state"]
    for cycle, wanted in BEFORE.items():
        row, true = fast[cycle], state[cycle]
        found = (row.acceleration_m_s2, row.joint_position_rad, true.deflection_m, true.tip_acceleration_m_s2)
        assert found == pytest.approx(wanted, rel=1e-9)
    for index, wanted_frame in FRAMES_BEFORE.items():
        frame = frames[index]
        assert (frame.frame, frame.received_s, frame.displacement_px) == pytest.approx(wanted_frame, rel=1e-9)
    assert len(frames) == 124
    assert sum(row.acceleration_m_s2 for row in fast) == pytest.approx(-130.809601904297, rel=1e-9)
    assert sum(row.displacement_px for row in frames) == pytest.approx(-3071.3047143494155, rel=1e-9)


@pytest.mark.parametrize("identifier", CAUSES)
def test_every_cause_runs_and_shows_in_the_recording(identifier: str) -> None:
    """In the sensors' rows where it sits before them; a cause of the image or of its timing in no fast row."""
    found = run(clear(identifier))
    place = CAUSES[identifier].place
    if place in {"camera", "timing"}:
        assert said(found, "/frames") != said(plain_rows(), "/frames")
        assert said(found, "/fast") == said(plain_rows(), "/fast")
    else:
        assert said(found, "/fast") != said(plain_rows(), "/fast")
    if place == "accelerometer":
        assert said(found, "/frames") == said(plain_rows(), "/frames")
    assert (said(found, "/truth/state") != said(plain_rows(), "/truth/state")) == (place in {"arm", "drive"})


def test_no_size_is_no_effect_in_any_row() -> None:
    """All causes at once, each at the value at which nothing happens."""
    none: list[dict[str, Any]] = []
    declared = {"dead_time_s": 0.002, "bandwidth_hz": 20.0, "max_velocity_rad_s": 0.6, "range_m_s2": 19.6}
    declared |= {"delay_s": 0.0, "rotation_px_per_rad": 0.0, "frequency_hz": 7.0, "onset_s": 1.0}
    for identifier, cause in CAUSES.items():
        if identifier == "second_bending_mode":  # brings its own share of the random disturbance with it
            continue
        effect: dict[str, Any] = {"cause": identifier}
        for parameter in cause.parameters:
            if parameter.default is not None:
                continue
            anything = parameter.neutral != parameter.neutral
            usual = declared.get(parameter.name, parameter.typical[0])
            effect[parameter.name] = usual if anything else parameter.neutral
        none.append(effect)
    assert len(none) == len(CAUSES) - 1
    found = run(*none)
    assert all(said(found, topic) == said(plain_rows(), topic) for topic in plain_rows())


def test_a_recording_with_effects_replays_to_the_same_numbers() -> None:
    """The controller answers what it was given, effects or not; a clock that steps does not disturb that."""
    scenario = msgspec.structs.replace(SCENARIO, damping=[Window(0.2, 2.0)])
    effects = [clear("gear_backlash"), clear("coulomb_damping"), clear("frame_drops"), clear("mains_hum")]
    found = run(*effects, {**clear("clock_step"), "clock": "all"}, scenario=scenario)
    replayed = compare_with_live(
        RecordedRun("rec", CONFIGURATION, MODEL, found["/fast"], found["/frames"], found["/estimate"])
    )
    assert replayed.cycles == 2000
    assert replayed.identical, replayed.first_difference


def test_lost_frames_show_as_gaps_and_a_triggered_camera_is_asked_again() -> None:
    drops = {"cause": "frame_drops", "fraction": 0.5}
    counters = [row.frame for row in run(drops)["/frames"]]
    assert 40 < len(counters) < 85
    assert counters == sorted(counters) and counters[-1] > 110
    camera = msgspec.structs.replace(MODEL.camera, mode="triggered")
    true = msgspec.structs.replace(MODEL, camera=camera, effects=[drops])
    recording, truth = Rows(), Rows()
    scenario = msgspec.structs.replace(SCENARIO, duration_s=8.0, moves=[])
    simulate(VirtualRun(CONFIGURATION, true, MODEL, scenario, 7), recording, truth)
    received = [row.received_s for row in recording.of["/frames"]]
    assert received[-1] > 6.5  # it would have starved within the first second


def test_a_stale_buffers_truth_is_the_images_own() -> None:
    """The truth file dates the image that was handed over: from onset on, one frame older."""
    onset = {"cause": "stale_frame_buffer", "onset_s": 1.0, "frames": 1}
    was, now = plain_rows(), run(onset)
    for a, b in zip(was["/truth/frames"], now["/truth/frames"], strict=True):
        late = a.mid_exposure_s - 0.0075 >= 1.0
        assert a.mid_exposure_s - b.mid_exposure_s == pytest.approx(1.0 / 65.0 if late else 0.0, abs=1e-9)
