"""A buffer that from an instant on holds more images than before, of a camera whose counter counts what is handed over.

Image and count go together, so that each shows what its count says, and comes later by as many frames as the buffer
holds. Without stamps a step of the delay by whole frames is the same (contract.md: a class).
"""

from dataclasses import replace

import numpy as np

from stillarm.diagnosis.fitting.fitted import Fit
from stillarm.diagnosis.forms.cause import Form, Values, plain
from stillarm.diagnosis.forms.causes.clock_step import CAUSE as CLOCK_STEP
from stillarm.diagnosis.forms.causes.stale_frame_buffer import LEAST_FRAMES, unwhole
from stillarm.diagnosis.physics.world import World

_ONSET, _STEP = "timing.step_onset_s", "timing.step_s"


def _needs(world: World) -> bool:
    unstamped = not np.isfinite(world.measured.frames.captured_s).any()
    return CLOCK_STEP.needs(world) and world.frame_clock.counted and unstamped


def _frames(fit: Fit) -> tuple[float, float]:
    """The step in frames, with its deviation."""
    rate_hz = fit.world.model.camera.frame_rate_hz
    return fit.value(_STEP) * rate_hz, fit.std.get(_STEP, 0.0) * rate_hz


def _values(fit: Fit) -> Values:
    frames, _ = _frames(fit)
    return plain(fit, onset_s=_ONSET) | {"frames": (float(max(round(frames), 1)), 0.0)}


FORM = Form(
    replace(
        CLOCK_STEP,
        id="stale_frame_buffer",
        needs=_needs,
        parameters_of=_values,
        prior_penalty=lambda fit: unwhole(*_frames(fit)),
        possible=lambda fit: _frames(fit)[0] > LEAST_FRAMES,
    ),
    "by the arrivals",
)
