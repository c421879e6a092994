"""Status, trust and reason of what the method says, each by the facts that it follows from."""

from cmath import exp
from collections.abc import Callable
from math import nan

import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.controller.estimation.estimate import Estimate, Status, Trust
from stillarm.controller.estimation.fused.method import FusedMethod
from tests.reference.ringing_world import model_for

NOW_S = 10.0


def said(change: Callable[[FusedMethod], object], known: bool = True) -> Estimate | None:
    """What is said of a vibration of 6 mm whose delay is known, but for what `change` does."""
    method = FusedMethod(model_for(0.006, 0.3), Settings().fused, "model")
    present, state = method._history.present, method.frames.state
    present.z[0] = 0.006 + 0j
    present.p = [[1e-8, 0.0], [0.0, 1e-8]]
    method._steps.last_frame_s = NOW_S - 0.01
    turn = [exp(1j * w * NOW_S) for w in method._w]
    if known:
        state.delay_std_s = 0.001
        method._stated.say(turn, NOW_S)
    change(method)
    return method._stated.say(turn, NOW_S)


def delay_std(std_s: float) -> Callable[[FusedMethod], object]:
    return lambda method: setattr(method.frames.state, "delay_std_s", std_s)


@pytest.mark.parametrize(
    ("known", "change", "status", "reason"),
    [
        (True, lambda method: None, Status.ESTIMATED, ""),
        (False, delay_std(0.02), Status.UNESTIMATED, "too little vibration seen yet"),
        (True, delay_std(0.02), Status.HELD, "the delay can no longer be seen"),
        (
            True,
            lambda method: method._history.present.z.__setitem__(0, 1e-5 + 0j),
            Status.HELD,
            "vibration too small to show the delay",
        ),
        (
            True,
            lambda method: setattr(method._steps, "last_frame_s", NOW_S - 0.3),
            Status.HELD,
            "no images",
        ),
    ],
    ids=["known", "never known", "no longer known", "too small", "no images"],
)
def test_the_delay_s_status_says_why(
    known: bool, change: Callable[[FusedMethod], object], status: Status, reason: str
) -> None:
    estimate = said(change, known)
    assert estimate is not None
    assert (estimate.delay.status, estimate.reason) == (status, reason)


def test_deviations_are_raised_by_what_innovations_say_of_them() -> None:
    """By the root of the mean innovation squared, with a trust that says so."""

    def doubt(method: FusedMethod) -> None:
        method.frames.consistency.factor, method.frames.consistency.doubtful = 2.0, True

    usual, raised = said(lambda method: None), said(doubt)
    assert usual is not None and raised is not None
    assert raised.deflection_std_m == pytest.approx(2.0 * usual.deflection_std_m)
    assert raised.delay.std_s == pytest.approx(2.0 * usual.delay.std_s)
    assert (usual.trusted, raised.trusted) == (Trust.SETTLED, Trust.DOUBTFUL)


def test_dates_that_are_suspected_are_in_both_deviations() -> None:
    """A phase of 0.1 rad: a tenth of the amplitude, and 0.1 / w of the delay."""
    estimate = said(lambda method: setattr(method.frames.state.date_watch, "suspected_rad", -0.1))
    assert estimate is not None
    assert estimate.deflection_std_m == pytest.approx(0.1 * 0.006, rel=0.03)
    assert estimate.delay.std_s == pytest.approx(0.1 / 16.3, rel=0.05)
    assert estimate.trusted is Trust.DOUBTFUL


def test_when_a_sensor_was_sampled_is_unknown_to_the_deflection_too() -> None:
    """0.4 ms of a rate: that of the vibration now, besides what its phasor is uncertain by."""
    estimate = said(lambda method: None)
    assert estimate is not None
    wanted = (1e-8 + (4e-4 * estimate.deflection_rate_m_s) ** 2) ** 0.5
    assert estimate.deflection_std_m == pytest.approx(wanted, rel=1e-6)


def test_numbers_that_are_none_are_not_said() -> None:
    assert said(lambda method: method._history.present.z.__setitem__(0, complex(nan, 0.0))) is None
