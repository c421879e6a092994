"""Whether an encoder's steps are what is left: the simulated angle, rounded to its counts, is then the measured one.

What rounding leaves of a slow motion is no noise, and other causes can make up for some of it. So beside an encoder's
steps a departure of its angle counts only beyond half a step.
"""

from dataclasses import replace

import numpy as np

from stillarm.diagnosis.driven.fitting.fitting import DrivenFit
from stillarm.diagnosis.driven.fitting.scoring import scored
from stillarm.diagnosis.driven.mechanisms.mechanisms import Form

COARSE_OF_MOTION = 1.0 / 500.0  # of an angle's variation: a finer step matters to nobody
MATCHING = 0.88  # of the samples: the noise is then below a seventh of the step, half of what the steps make
CAUSE = "encoder_quantisation"


def quantised(final: DrivenFit) -> tuple[Form, str, float, float] | None:
    """The form, the channel, its step in the channel's unit, and how much of the held-out error rounding takes away."""
    if final.box.driven.joins:  # each recording counts from a zero of its own
        each = [quantised(final.part(k)) for k in range(final.box.driven.recordings)]
        return each[0] if all(one is not None for one in each) else None
    inside = final.box.split.held[final.box.block]
    for one in final.box.driven.outputs:
        usual = float(np.nanstd(one.values))
        if f"step {one.name}" in final.box.declared:
            continue
        if one.kind not in ("position", "motor") or one.step < COARSE_OF_MOTION * usual:
            continue
        phase = one.values[np.flatnonzero(np.isfinite(one.values))[0]]
        rounded = phase + one.step * np.rint((final.run.outputs[one.name] - phase) / one.step)
        left = one.values - rounded
        known = np.isfinite(left)
        if np.mean(np.abs(left[known]) < 0.5 * one.step) > MATCHING:
            before = final.rms(one.name, True)
            after = float(np.sqrt(np.nanmean(left[inside] ** 2)))
            form = Form(CAUSE, f"steps of {one.step:.4g} in {one.name}", ("step",), lambda fitted: iter(()))
            return form, one.name, one.step, 1.0 - after / before
    return None


def beyond_half_a_step(fitted: DrivenFit, channel: str) -> DrivenFit:
    """The fit as it is judged beside an encoder's steps."""
    fitted = fitted.likeliest
    step = next(one.step for one in fitted.box.driven.outputs if one.name == channel)
    left = fitted.residuals[channel]
    beyond = np.sign(left) * np.maximum(np.abs(left) - 0.5 * step, 0.0)
    held, whole = scored(fitted.box, {**fitted.residuals, channel: beyond})
    return replace(fitted, held_bands=held, whole_bands=whole)
