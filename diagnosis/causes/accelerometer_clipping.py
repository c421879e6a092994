"""An accelerometer that clips."""

import numpy as np

from diagnosis.cause import Cause, Context, Trial, free_of, has, plain
from diagnosis.ceiling import ceiling_of


def _trials(context: Context) -> list[Trial]:
    shown = float(np.max(np.abs(context.fit.predicted.channels["acceleration"]))) or 1.0
    trials = [
        Trial({}, ({"accelerometer.range_m_s2": share * shown},), one_sided=True)
        for share in (0.95, 0.88, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
    ]
    ceiling = ceiling_of(context.world.channels["acceleration"], context.fit.sigma["acceleration"])
    if ceiling is not None:
        trials.append(Trial({}, ({"accelerometer.range_m_s2": ceiling},), one_sided=True, certain=True))
    return trials


CAUSE = Cause(
    id="accelerometer_clipping",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of("accelerometer.range_m_s2"),
    parameters_of=lambda fit: plain(fit, range_m_s2="accelerometer.range_m_s2"),
    settle={"accelerometer.range_m_s2": 0.02},
)
