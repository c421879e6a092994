"""The error that the accelerometer's noise leaves to anybody: that of an oracle which lacks the vibration's time alone.

An image tells its own instant only by when it arrived; what tells how long it took is the accelerometer. An oracle that
knows the whole waveform a(t) of the true acceleration, but not its time, has from the samples y up to an instant

    shift = sum((y - a) a') / sum(a'^2),    standard deviation sigma / sqrt(sum(a'^2))

(least squares; Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, example 3.13: no unbiased
estimate has less). No method that has to learn frequency, damping and delay besides can expect a smaller error.
"""

import numpy as np

from stillarm.benchmarks.live.scoring import Estimates, score
from stillarm.benchmarks.live.truth import TrueRun, Values

_IMPACT_S = 0.05  # about a strike, whose acceleration is no vibration's


def bound_of(truth: TrueRun, time_s: Values, acceleration_m_s2: Values, scale: float = 1.0) -> float | None:
    """Mean error of the oracle in a run, scored as any method's. time_s, acceleration_m_s2: the recorded samples, NaN
    where none was read. scale: the accelerometer's, of the model file. The joint is taken to be still."""
    said = oracle_deflection(truth, time_s, acceleration_m_s2 / scale)
    unstated, no_frames = np.full(len(time_s), np.nan), np.empty(0)
    oracle = Estimates(
        time_s, said, unstated, np.empty(0, np.int64), no_frames, delay_s=no_frames, delay_std_s=no_frames
    )
    return score(oracle, truth)["error_mean"]


def oracle_deflection(truth: TrueRun, time_s: Values, acceleration_m_s2: Values) -> Values:
    """The true deflection, m, at the time that the samples up to each instant make the oracle believe."""
    step_s = float(truth.time_s[1] - truth.time_s[0])
    waveform = np.gradient(np.gradient(truth.deflection_m, step_s), step_s)
    known = np.interp(time_s, truth.time_s, waveform)
    slope = np.gradient(known, time_s)
    used = np.isfinite(acceleration_m_s2) & (time_s > truth.swings[0].begin_s)
    for swing in truth.swings:
        used &= np.abs(time_s - swing.begin_s) > _IMPACT_S
    slope = np.where(used, slope, 0.0)
    departed = np.where(used, acceleration_m_s2 - known, 0.0)
    seen = np.cumsum(slope * slope)
    shift_s = np.divide(np.cumsum(slope * departed), seen, out=np.zeros(len(time_s)), where=seen > 0.0)
    there: Values = np.interp(time_s + shift_s, truth.time_s, truth.deflection_m)
    return there
