"""What planned moves would show, by a model that is only roughly known: so that they stay within the bounds."""

from math import nan

import numpy as np

from stillarm.common.files.model import Model
from stillarm.common.files.scenario import Scenario
from stillarm.diagnosis.commissioning.plan import slowed
from stillarm.diagnosis.commissioning.watch import Bounds
from stillarm.diagnosis.data.measured import Frames, Measured
from stillarm.diagnosis.physics.world import World

_SHARE = 0.75  # of the bounds: the model is rough


def expected(scenario: Scenario, model: Model) -> Bounds:
    """Greatest joint angle, rad, image displacement, px, and acceleration as the sensor shows it, m/s^2."""
    cycle_s = model.timing.cycle_s
    times = np.arange(round(scenario.duration_s / cycle_s)) * cycle_s
    command = np.array([scenario.reference_rad_s(float(t)) for t in times])
    none, empty = np.full(len(times), nan), np.empty(0)
    frames = Frames(np.empty(0, np.int64), empty, empty, empty, empty)
    planned = Measured(
        "plan", cycle_s, 0.0, command, command, none, none, none, np.zeros(len(times)), none, frames, empty
    )
    world = World(planned, model)
    motion = world.move(world.space.vector())
    sensor, camera = model.accelerometer, model.camera
    return Bounds(
        float(np.max(np.abs(motion.joint[:, 0]))),
        abs(camera.scale_px_per_m) * float(np.max(np.abs(motion.tip))),
        abs(sensor.scale) * float(np.max(np.abs(motion.tip_acceleration)))
        + abs(sensor.bias_m_s2)
        + 4.0 * sensor.noise_std_m_s2,
    )


def fitted_to(scenario: Scenario, model: Model, bounds: Bounds) -> Scenario:
    """The moves, as much slower as the bounds ask for."""
    share = 1.0
    for _ in range(3):  # the accelerometer's bias and noise do not shrink with the moves
        shown = expected(slowed(scenario, share), model)
        worst = max(
            shown.angle_rad / bounds.angle_rad,
            shown.image_px / bounds.image_px,
            shown.acceleration_m_s2 / bounds.acceleration_m_s2,
        )
        share = min(share, share * _SHARE / max(worst, 1e-9))
    return slowed(scenario, share)
