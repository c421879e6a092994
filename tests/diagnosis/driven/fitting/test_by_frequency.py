"""A fit is judged where the score is best: strong noise of low frequencies does not outweigh what the others tell."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import lfilter

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit, fit
from stillarm.diagnosis.driven.greybox.greybox import GreyBox
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.recording.signals import Driven, Output

STEP_S, GAIN = 0.01, 2.0
NAME = "joint_velocity_rad_s"


def _fitted(slow: float) -> DrivenFit:
    """A joint without damping, its gain alone free. slow: how strong the noise of the lowest frequencies is, over the
    rest: up to eight whole periods a block, so that none of it leaks to others."""
    rng = np.random.default_rng(5)
    u = np.sign(rng.standard_normal(3000)).repeat(2)[:3000]
    velocity = GAIN * STEP_S * lfilter([0.0, 1.0], [1.0, -1.0], u)
    split, noise = irregular(30.0), np.zeros(3000)
    edges = np.rint(split.edges_s / STEP_S).astype(int)
    for begins, ends in pairwise(edges):
        turns = 2.0 * np.pi * np.arange(ends - begins) / (ends - begins)
        for periods in range(1, 9):
            noise[begins:ends] += np.sin(periods * turns + 6.3 * rng.random()) * rng.standard_normal()
    seen = velocity + 0.002 * rng.standard_normal(3000) + 0.002 * slow * noise
    output = Output(NAME, "velocity", np.asarray(seen), True, 0.0)
    driven = Driven("x", STEP_S, 0.0, "motor_current_a", u, True, (output,), {})
    numbers = {"gain": 0.9 * GAIN, "damping": 0.0, "delay": 0.0, "held": 1.0, f"offset {NAME}": 0.0}
    return fit(GreyBox(driven, split), numbers, ("gain",))


def _trained(fitted: DrivenFit) -> float:
    return float(fitted.held_out[~fitted.box.split.held].sum())


def test_the_likeliest_numbers_are_those_of_the_quiet_frequencies() -> None:
    fitted = _fitted(100.0)
    judged = fitted.likeliest
    assert _trained(judged) > _trained(fitted) + 5.0
    errors = [abs(one.numbers["gain"] - GAIN) for one in (fitted, judged)]
    assert errors[1] < 0.25 * errors[0]
    assert judged.likeliest is judged and fitted.likeliest is judged


def test_beside_white_noise_the_fit_is_the_likeliest_already() -> None:
    fitted = _fitted(0.0)
    assert 0.0 <= _trained(fitted.likeliest) - _trained(fitted) < 2.0
    assert fitted.likeliest.numbers["gain"] == pytest.approx(fitted.numbers["gain"], rel=1e-3)
