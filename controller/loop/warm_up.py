"""Runs the step on a synthetic vibration before the first cycle.

Structures that are made on first use (numpy's dispatch tables, buffers of the linear algebra, the interpreter's inline
caches) are then ready before the first real cycle. This takes 60 ms once, before memory is locked. The vibration is
plausible for the model, with late images and an impact half-way, so that fit, impact and damping all run.
"""

import contextlib
from collections.abc import Iterator
from math import cos, pi

import msgspec

from stillarm.common.datagrams.visual_sample import TrackingStatus, VisualSample
from stillarm.common.files.configuration import Controller as ControllerSettings
from stillarm.common.files.model import Model
from stillarm.common.user_error import UserError
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.step import Controller
from stillarm.controller.safety.adjusting import offered_methods

_CYCLES = 1200  # 60 ms of computing
_STRUCK_AT = 700  # cycles
_CYCLES_A_FRAME = 15  # 65 frames a second
_AMPLITUDE_M = 0.005  # order of magnitude of damped vibrations
_VARIANCE_PX2 = 0.0025


def warm_up(model: Model, settings: ControllerSettings, model_name: str) -> None:
    """Step a temporary controller of each method that an operator may choose through a vibration.

    That controller is always armed: it moves nothing, and must run the same code as an armed one.
    """
    for method in offered_methods(settings):
        with contextlib.suppress(
            UserError
        ):  # one that this model cannot have is refused when it is asked for
            _warm(model, msgspec.structs.replace(settings, method=method), model_name)


def _warm(model: Model, settings: ControllerSettings, model_name: str) -> None:
    controller = Controller(model, msgspec.structs.replace(settings, arm_at_start=True), model_name)
    for read in vibration_cycles(model, _CYCLES):
        controller.step(read)


def vibration_cycles(model: Model, cycles: int) -> Iterator[CycleInput]:
    """What a controller reads of that vibration, from its first cycle on. The joint stands still."""
    mode, cycle_s = model.arm.modes[0], model.timing.cycle_s
    w, late = mode.angular_frequency, round(model.timing.capture_delay_s / cycle_s)

    def deflection_m(cycle: int) -> float:
        grown = 2.0 if cycle >= _STRUCK_AT else 1.0
        return grown * _AMPLITUDE_M * cos(w * cycle * cycle_s + 0.5 * pi * (cycle >= _STRUCK_AT))

    for cycle in range(cycles):
        samples = []
        if cycle % _CYCLES_A_FRAME == 0 and cycle >= late:
            samples.append(
                VisualSample(
                    frame=cycle // _CYCLES_A_FRAME,
                    started_cycle=max(0, cycle - late - _CYCLES_A_FRAME),
                    status=TrackingStatus.MEASURED,
                    displacement_x_px=-model.camera.scale_px_per_m * deflection_m(cycle - late),
                    variance_x_px2=_VARIANCE_PX2,
                    variance_y_px2=_VARIANCE_PX2,
                )
            )
        acceleration = -model.accelerometer.scale * w * w * deflection_m(cycle)
        yield CycleInput(cycle, acceleration, 0.0, 0.0, 0.0, 0.0, True, samples)
