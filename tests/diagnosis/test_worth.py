"""Whether a cause is large enough to have a name."""

from dataclasses import replace

import numpy as np
import pytest

from stillarm.common.causes import CAUSES as CATALOGUE
from stillarm.diagnosis.candidate import Candidate
from stillarm.diagnosis.catalogue import CAUSES
from stillarm.diagnosis.choice import choose, too_small
from stillarm.diagnosis.laws import LawFound
from stillarm.diagnosis.screen import Screening
from stillarm.diagnosis.worth import worth_a_name
from tests.fixtures.synthetic import fitted, measured

LAST = fitted(measured(6.0, 3))
SCREENING = Screening([], threshold_nats=8.0)


def candidate(cause: str, **values: float) -> Candidate:
    """A cause that all data speak for, of that size."""
    given = {name: (value, 1e-9) for name, value in values.items()}
    free = CAUSES[cause].free(LAST.world)
    return Candidate(cause, LAST, 200.0, 100.0, 0.0, np.full(10, 10.0), given, free=free)


@pytest.mark.parametrize(
    ("small", "large"),
    [
        (candidate("payload_change", onset_s=3.0, frequency_ratio=1.000008),
         candidate("payload_change", onset_s=3.0, frequency_ratio=0.997)),
        (candidate("joint_friction", velocity_loss_rad_s=1.6e-5),
         candidate("joint_friction", velocity_loss_rad_s=5e-4)),
        (candidate("drive_lag", bandwidth_hz=LAST.value("drive.bandwidth_hz") * 1.002),
         candidate("drive_lag", bandwidth_hz=LAST.value("drive.bandwidth_hz") * 0.97)),
        (candidate("drive_dead_time", dead_time_s=LAST.value("drive.dead_time_s") + 7e-6),
         candidate("drive_dead_time", dead_time_s=LAST.value("drive.dead_time_s") + 1e-3)),
        (candidate("mains_hum", frequency_hz=50.0, amplitude_m_s2=1e-3, phase_rad=1.0),
         candidate("mains_hum", frequency_hz=50.0, amplitude_m_s2=5e-3, phase_rad=1.0)),
    ],
)  # fmt: skip
def test_a_cause_far_below_what_is_typical_has_no_name(small: Candidate, large: Candidate) -> None:
    assert not worth_a_name(small)
    assert worth_a_name(large)
    assert choose([small], SCREENING) is None
    assert too_small([small], SCREENING) is small
    assert choose([large], SCREENING) is large
    assert too_small([large], SCREENING) is None


def test_behind_one_that_is_too_small_only_what_arrivals_show_is_taken() -> None:
    """An arm that is a little off changes none of them; but others may be likenesses of the same."""
    small = candidate("payload_change", onset_s=3.0, frequency_ratio=1.000008)
    drift = replace(candidate("delay_drift", rate_s_per_s=0.001), train_gain=150.0, held_out_gain=80.0)
    tilt = replace(
        candidate("camera_tilt_coupling", rotation_px_per_rad=40.0), train_gain=150.0, held_out_gain=80.0
    )
    assert choose([small, tilt, drift], SCREENING) is drift
    assert choose([small, tilt], SCREENING) is None


def test_a_limit_is_worth_a_name_wherever_it_lies() -> None:
    assert worth_a_name(
        candidate("accelerometer_clipping", range_m_s2=LAST.value("accelerometer.range_m_s2"))
    )


def test_a_lens_is_worth_a_name_by_what_it_does_at_the_images_edge() -> None:
    """A seventh of a per cent there is, in whatever units of length the tip swings."""
    last = fitted(measured(6.0, 3))
    shown = last.world.channels["displacement"]
    for widest in (400.0, 1500.0):
        shown[:] *= widest / np.nanmax(np.abs(shown))
        for share, named in ((1.5e-3, True), (1e-5, False)):
            lens = replace(candidate("lens_distortion", coefficient_per_px2=share / widest**2), fit=last)
            assert worth_a_name(lens) is named


@pytest.mark.parametrize("cause", sorted(CATALOGUE))
def test_the_least_that_is_typical_is_worth_a_name(cause: str) -> None:
    """Of every cause, departures from what is declared taken to be as large as its typical value."""
    values = {}
    for one in CATALOGUE[cause].parameters:
        if one.kind == "number":
            declared = LAST.world.space[CAUSES[cause].free(LAST.world)[0]].start if cause in CAUSES else 0.0
            neutral = one.neutral if np.isfinite(one.neutral) else declared
            values[one.name] = neutral + one.typical[0]
    assert worth_a_name(candidate(cause, **values) if cause in CAUSES else _of_law(cause, values))


def _of_law(cause: str, values: dict[str, float]) -> Candidate:
    return Candidate(cause, LAST, 1.0, 1.0, 0.0, np.zeros(10), {k: (v, 0.0) for k, v in values.items()})


def test_what_does_less_well_than_a_cause_too_small_is_a_likeness_of_the_same() -> None:
    small = candidate("joint_friction", velocity_loss_rad_s=1.6e-5)
    other = replace(
        candidate("drive_deadband", deadband_rad_s=4e-4), train_gain=90.0, held_out_gain=40.0,
        block_gains=np.full(10, 4.0),
    )  # fmt: skip
    assert choose([other], SCREENING) is other
    assert choose([small, other], SCREENING) is None


def test_a_law_is_found_beside_a_cause_too_small() -> None:
    small = candidate("joint_friction", velocity_loss_rad_s=1.6e-5)
    gains = np.full(10, 30.0)
    law = replace(small, cause="frame_drops", values={}, law=LawFound("frame_drops", {}, 300.0, gains))
    assert choose([small, law], SCREENING) is law
