"""The baseline with the modes, or the images, that the model states, where the fitted one has left them far behind.

What acts throughout may bend a baseline as far as it goes: an arm that dry friction stops within a swing is fitted with
another frequency and forty times the damping, and from there no direction leads to the friction. Beside the modes as
stated the cause is plain, whatever else these leave. A mode that rings on without damping imitates a hum, and takes it
over where it is near; that mode alone is held then. An image that turns with the joint is fitted with a camera that is
upside down and half a swing late, and from there no direction leads to the tilt.
"""

import numpy as np

from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.events.impacts import without_impacts_while_moving
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, carried_over, make_data

_FAR = 1.15  # times a mode's frequency, or its inverse: no measured model is as wrong
_FAR_DAMPING, _DAMPED = 5.0, 0.05  # times its damping, and that it has at least: an arm that hardly rings
_STDS = 3.0  # by which a mode's damping is below that, for it to be driven by something else
_OF_A_SWING = 0.25  # by which a delay is off, for another swing to fit nearly as well
_OF_IMAGES = ("camera.scale_px_per_m", "timing.capture_delay_s")
_STEPS = 6  # of a fit of all but what is stated


def stated_baseline(baseline: Fit, split: Split) -> Fit | None:
    """The recording as what is stated foretells it, of that which the baseline has left, all else fitted; None where it
    has left nothing."""
    if baseline.world.measured.pair:
        return None
    left = _left(baseline)
    if not left:
        return None
    fewer = without_impacts_while_moving(baseline)
    space = fewer.space
    stated = {name: space[name].start for name in space.names(left)}
    start = space.with_values(carried_over(baseline, fewer), stated)
    names = [name for name in fewer.baseline_names() if name not in stated]
    return fit(make_data(fewer, split), start, names, iterations=_STEPS, colour=baseline.colour)


def _left(baseline: Fit) -> tuple[str, ...]:
    """Of what the model states, that a fit has left far behind: the modes, or how the images show them."""
    left: list[str] = []
    if _arm_left(baseline):
        left.append("modes.")
    else:
        left += [f"modes.{i}." for i in range(baseline.world.modes) if _rings_on(baseline, i)]
    if _images_left(baseline):
        left += _OF_IMAGES
    return tuple(left)


def _arm_left(baseline: Fit) -> bool:
    """Whether a fit has made another arm of its first mode."""
    space = baseline.world.space
    ratio = baseline.value("modes.0.frequency_hz") / space["modes.0.frequency_hz"].start
    damping, stated = baseline.value("modes.0.damping_ratio"), space["modes.0.damping_ratio"].start
    return max(ratio, 1.0 / ratio) > _FAR or damping > max(_FAR_DAMPING * stated, _DAMPED)


def _rings_on(baseline: Fit, mode: int) -> bool:
    """Whether a fit has left a mode next to no damping: no arm has, and something else vibrates on."""
    name = f"modes.{mode}.damping_ratio"
    most = baseline.value(name) + _STDS * baseline.std.get(name, np.inf)
    return _FAR_DAMPING * most < baseline.world.space[name].start


def _images_left(baseline: Fit) -> bool:
    """Whether a fit has turned the images over, or dated them by another swing."""
    scale, space = "camera.scale_px_per_m", baseline.world.space
    turned_over = baseline.value(scale) * space[scale].start < 0.0
    return "displacement" in baseline.residuals and (turned_over or dated_by_another_swing(baseline))


def dated_by_another_swing(one: Fit) -> bool:
    """Whether a fit dates the images so far from where they are stated to be that another swing fits nearly as well."""
    delay = "timing.capture_delay_s"
    off_s = abs(one.value(delay) - one.world.space[delay].start)
    return off_s * one.value("modes.0.frequency_hz") > _OF_A_SWING
