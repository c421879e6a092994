"""Runs the step a few hundred times on made-up data before the first cycle.

What is made on first use (numpy's dispatch tables, the linear algebra's buffers, the interpreter's inline caches)
is made then, not in the first cycles that count: 40 ms, once, when memory is locked.
"""

from math import cos, pi

from common.configuration import Controller as ControllerSettings
from common.model import Model
from common.visual_sample import VisualSample
from controller.cycle_input import CycleInput
from controller.step import Controller

_CYCLES = 400
_CYCLES_A_FRAME = 15


def warm_up(model: Model, settings: ControllerSettings, model_name: str) -> None:
    """Step a controller of its own through a vibration; nothing of it remains."""
    controller = Controller(model, settings, model_name)
    step_angle = 2.0 * pi * model.arm.modes[0].frequency_hz * model.timing.cycle_s
    for cycle in range(_CYCLES):
        wave = cos(step_angle * cycle)
        samples = []
        if cycle % _CYCLES_A_FRAME == 0:
            samples.append(VisualSample(cycle // _CYCLES_A_FRAME, max(0, cycle - 60), 0, wave))
        controller.step(CycleInput(cycle, wave, 0.0, 0.0, 0.0, 0.0, True, samples))
