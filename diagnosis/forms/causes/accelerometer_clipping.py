"""An accelerometer that clips."""

import numpy as np

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Cause, Context, Trial, Values, free_of, has
from stillarm.diagnosis.physics.quantities import RANGE
from stillarm.diagnosis.sensors.accelerometer_faults import ceiling_of, plateau_of


def _trials(context: Context) -> list[Trial]:
    sensor = context.fit.channel("acceleration")
    if sensor is None:
        return []
    shown = float(np.max(np.abs(sensor.predicted))) or 1.0
    trials = [
        Trial({}, ({RANGE: share * shown},), one_sided=True)
        for share in (0.95, 0.88, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
    ]
    plateau = plateau_of(sensor.measured, sensor.predicted, sensor.sigma)
    # at the range that is simulated it says nothing
    if plateau is not None and plateau < context.value(RANGE):
        trials.append(Trial({}, ({RANGE: plateau},), one_sided=True, exact=True, certain=True))
    ceiling = ceiling_of(sensor.measured, sensor.sigma)
    if ceiling is not None:
        trials.append(Trial({}, ({RANGE: ceiling},), one_sided=True, certain=True))
    return trials


def _values(fit: Fit) -> Values:
    """The range; where it shows in no sample that trained, by those that are held out."""
    value, std = fit.value(RANGE), fit.std.get(RANGE, 0.0)
    sensor = fit.channel("acceleration")
    if sensor is not None and std == 0.0:
        std = sensor.sigma / max(float(np.sum(np.abs(sensor.predicted) >= value)), 1.0) ** 0.5
    return {"range_m_s2": (value, std)}


CAUSE = Cause(
    id="accelerometer_clipping",
    needs=has("acceleration"),
    trials=_trials,
    free=free_of(RANGE),
    parameters_of=_values,
    settle={RANGE: 0.02},
)
