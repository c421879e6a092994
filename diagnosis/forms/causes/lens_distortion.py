"""A lens that distorts."""

import numpy as np

from stillarm.diagnosis.forms.cause import Cause, Context, Trial, free_of, has, plain


def _trials(context: Context) -> list[Trial]:
    seen = context.world.measured.frames.displacement_px
    known = context.declared("camera.lens_per_px2")
    widest = float(np.nanmax(np.abs(seen))) or 1.0
    return [
        Trial({}, ({"camera.lens_per_px2": known + share / widest**2},))
        for share in (0.001, 0.03, -0.03, 0.15, -0.15)
    ]


CAUSE = Cause(
    id="lens_distortion",
    needs=has("displacement"),
    trials=_trials,
    free=free_of("camera.lens_per_px2"),
    parameters_of=lambda fit: plain(fit, coefficient_per_px2="camera.lens_per_px2"),
)
