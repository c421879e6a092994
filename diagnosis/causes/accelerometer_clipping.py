"""An accelerometer that clips."""

import numpy as np

from diagnosis.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    shown = float(np.max(np.abs(context.fit.predicted.channels["acceleration"]))) or 1.0
    trials = [
        Trial({}, ({"accelerometer.range_m_s2": share * shown},), one_sided=True)
        for share in (0.95, 0.88, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
    ]
    ceiling = _ceiling(context)
    if ceiling is not None:
        trials.append(Trial({}, ({"accelerometer.range_m_s2": ceiling},), one_sided=True, certain=True))
    return trials


def _ceiling(context: Context) -> float | None:
    """The level at which samples pile up on both sides, m/s^2: more of them about it than in the tenth below."""
    values = context.world.channels["acceleration"]
    values = np.abs(values[np.isfinite(values)])
    noise = context.fit.sigma["acceleration"]
    counts, edges = np.histogram(values, bins=40)
    top = int(np.argmax(counts[8:])) + 8
    if counts[top] < 0.05 * len(values) or counts[top] < 1.5 * counts[top // 2]:
        return None
    level = float(0.5 * (edges[top] + edges[top + 1]))
    return level if level > 2.0 * noise else None


CAUSE = Cause(
    id="accelerometer_clipping",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of("accelerometer.range_m_s2"),
    parameters_of=lambda fit: plain(fit, range_m_s2="accelerometer.range_m_s2"),
    settle={"accelerometer.range_m_s2": 0.02},
)
