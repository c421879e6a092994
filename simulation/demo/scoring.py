"""The demo's figures of merit: damping and predictions against the rig's true motion."""

from dataclasses import dataclass
from math import isfinite, nan, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Model
from stillarm.controller.replay.replay import MethodRun
from stillarm.simulation.demo.ring_down import (
    decay_rate_per_s,
    envelope_m,
    fitted_settling_time_s,
    settling_time_s,
)

Values = NDArray[np.float64]

_SCORED_DOWN_TO = 0.3  # of the struck amplitude
_ONSET_S = 0.3  # after a strike: the image is late, so the damping sets in only then
_DAMPED_FIT_DOWN_TO = 0.1


@dataclass(frozen=True)
class Truth:
    """The rig's true motion, on the controller's clock.

    time_s, deflection_m: each step, shape (steps,). strikes_s: times of the strikes. mid_exposure_s: by frame.
    """

    time_s: Values
    deflection_m: Values
    strikes_s: list[float]
    mid_exposure_s: dict[int, float]


def damping_scores(truth: Truth, model: Model, damping_on_s: float) -> dict[str, float | None]:
    """Settling times and damping ratios after the first strike (free until `damping_on_s`) and after the second."""
    frequency = model.arm.modes[0].frequency_hz
    step = float(np.median(np.diff(truth.time_s)))
    free_from, damped_from = truth.strikes_s[0], truth.strikes_s[1]
    free = _envelope_between(truth, free_from, damping_on_s, step, frequency)
    damped = _envelope_between(truth, damped_from, float(truth.time_s[-1]), step, frequency)
    struck_free = struck_amplitude_m(truth, free_from, frequency)
    struck_damped = struck_amplitude_m(truth, damped_from, frequency)
    free_rate = decay_rate_per_s(free, step, struck_free, _SCORED_DOWN_TO)
    onset = round(_ONSET_S / step)
    damped_rate = decay_rate_per_s(damped[onset:], step, struck_damped, _DAMPED_FIT_DOWN_TO)
    return {
        "settling_time_free_s": settling_time_s(free, step, struck_free),
        "settling_time_damped_s": settling_time_s(damped, step, struck_damped),
        "settling_time_free_fitted_s": fitted_settling_time_s(free_rate) if free_rate else None,
        "damping_ratio_free": free_rate / (2.0 * pi * frequency) if free_rate else None,
        "damping_ratio_damped": damped_rate / (2.0 * pi * frequency) if damped_rate else None,
    }


def method_scores(run: MethodRun, truth: Truth, model: Model) -> dict[str, Any]:
    """Delay and prediction errors of a method while the arm rings freely, from the strike down to 30 %."""
    frequency = model.arm.modes[0].frequency_hz
    from_s, to_s = scored_span_s(truth, frequency)
    amplitude = struck_amplitude_m(truth, from_s, frequency)
    times = np.array(run.times_s)
    said = np.array([e.deflection_m for e in run.estimates])
    inside = (times >= from_s) & (times < to_s)
    true = np.interp(times[inside], truth.time_s, truth.deflection_m)
    said = np.where(np.isfinite(said[inside]), said[inside], 0.0)  # no prediction: nothing would be damped
    error = np.abs(said - true) / amplitude
    delays, delay_errors = [], []
    for frame, received_s, said_of_frame in run.frames:
        delay = said_of_frame.delay_s
        if not from_s <= received_s < to_s or not isfinite(delay):
            continue
        delays.append(delay)
        mid = truth.mid_exposure_s.get(frame, nan)
        if isfinite(mid):
            delay_errors.append(delay - (received_s - mid))
    return {
        "delay_mean_s": _mean(delays),
        "delay_std_s": float(np.std(delays)) if delays else None,
        "delay_error_rms_s": float(np.sqrt(np.mean(np.square(delay_errors)))) if delay_errors else None,
        "prediction_error_mean": float(np.mean(error)) if len(error) else None,
        "prediction_error_max": float(np.max(error)) if len(error) else None,
        "pmcc": float(np.corrcoef(said, true)[0, 1]) if len(error) > 2 and np.std(said) > 0.0 else None,
    }


def scored_span_s(truth: Truth, frequency_hz: float) -> tuple[float, float]:
    """From the first strike until the free vibration has fallen to 30 % of its amplitude, or the next strike."""
    from_s = truth.strikes_s[0]
    end = truth.strikes_s[1] if len(truth.strikes_s) > 1 else float(truth.time_s[-1])
    step = float(np.median(np.diff(truth.time_s)))
    envelope = _envelope_between(truth, from_s, end, step, frequency_hz)
    amplitude = struck_amplitude_m(truth, from_s, frequency_hz)
    below = np.flatnonzero(envelope < _SCORED_DOWN_TO * amplitude)
    return from_s, from_s + (below[0] * step if len(below) else end - from_s)


def struck_amplitude_m(truth: Truth, strike_s: float, frequency_hz: float) -> float:
    """Greatest deflection within a period of a strike, m."""
    near = (truth.time_s >= strike_s) & (truth.time_s < strike_s + 1.0 / frequency_hz)
    return float(np.max(np.abs(truth.deflection_m[near])))


def _envelope_between(truth: Truth, from_s: float, to_s: float, step_s: float, frequency_hz: float) -> Values:
    span = (truth.time_s >= from_s) & (truth.time_s < to_s)
    return envelope_m(truth.deflection_m[span], step_s, frequency_hz)


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None
