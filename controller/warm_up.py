"""Runs the step on a made-up vibration before the first cycle.

What is made on first use (numpy's dispatch tables, the linear algebra's buffers, the interpreter's inline caches)
is made then, not in the first cycles that count: 60 ms, once, before memory is locked. The vibration is one that the
model allows, seen by late images and struck again half-way, so that fit, impact and damping all run.
"""

from math import cos, pi

import msgspec

from common.configuration import Controller as ControllerSettings
from common.model import Model
from common.visual_sample import TrackingStatus, VisualSample
from controller.cycle_input import CycleInput
from controller.step import Controller

_CYCLES = 1200
_STRUCK_AT = 700  # cycles
_CYCLES_A_FRAME = 15
_AMPLITUDE_M = 0.005  # of the order of the vibrations that are damped
_VARIANCE_PX2 = 0.0025


def warm_up(model: Model, settings: ControllerSettings, model_name: str) -> None:
    """Step a controller of its own through a vibration; nothing of it remains.

    That controller is armed whatever the settings say: it moves nothing, and is to run what an armed one runs.
    """
    controller = Controller(model, msgspec.structs.replace(settings, arm_at_start=True), model_name)
    mode, cycle_s = model.arm.modes[0], model.timing.cycle_s
    w, late = mode.angular_frequency, round(model.timing.capture_delay_s / cycle_s)

    def deflection_m(cycle: int) -> float:
        grown = 2.0 if cycle >= _STRUCK_AT else 1.0
        return grown * _AMPLITUDE_M * cos(w * cycle * cycle_s + 0.5 * pi * (cycle >= _STRUCK_AT))

    for cycle in range(_CYCLES):
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
        controller.step(CycleInput(cycle, acceleration, 0.0, 0.0, 0.0, 0.0, True, samples))
