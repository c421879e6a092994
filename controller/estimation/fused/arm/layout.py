"""Where each quantity stands in a filter's state, and the constants of the arm and its sensors.

Implements Eqs. 1, 6 of docs/fused.md.
"""

from math import pi, sqrt

import numpy as np

from stillarm.common.files.beam import tip_slopes_per_m
from stillarm.common.files.model import Model
from stillarm.controller.joint.sensor_deflection import shown_of


class Layout:
    """State of n = 4 m + 8 numbers for m modes; the slices and indices below say what is where.

    phasor: a_1, b_1, a_2, b_2, ...: mode i deflects a_i cos(w_i t) + b_i sin(w_i t), m (w_i damped, nominal)
    frequency: departure of w_i from nominal, rad/s. decay: departure of zeta_i w_i, 1/s
    offset: image zero, m. scale: relative error of the image scale. bias: of the accelerometer, as deflection, m
    shift: mid-exposure minus the nominal instant of the dating law, s. skew: relative error of that law's clock
    late: mean capture delay less the model's, s, for the laws that do not date by arrival
    ahead: by how much n_i precedes mid-exposure, less a frame, s
    force: static deflection by a force that lasts, m (held_force.py)
    """

    def __init__(self, model: Model, length_m: float) -> None:
        """For all modes of the model."""
        modes = model.arm.modes
        self.modes = m = len(modes)
        self.cosine, self.sine = slice(0, 2 * m, 2), slice(1, 2 * m, 2)
        self.phasor = slice(0, 2 * m)
        self.frequency, self.decay = slice(2 * m, 3 * m), slice(3 * m, 4 * m)
        self.offset, self.scale, self.bias, self.shift, self.skew, self.late, self.ahead, self.force = range(
            4 * m, 4 * m + 8
        )
        self.size = 4 * m + 8
        self.w = np.array([mode.angular_frequency * sqrt(1.0 - mode.damping_ratio**2) for mode in modes])
        self.sigma = np.array([mode.damping_ratio * mode.angular_frequency for mode in modes])
        self.w_first = modes[0].angular_frequency
        self.input_gain = [
            -mode.participation * length_m / w for mode, w in zip(modes, self.w.tolist(), strict=True)
        ]
        camera = model.camera
        slopes = tip_slopes_per_m(length_m, m)
        first = camera.scale_px_per_m + camera.rotation_px_per_rad * slopes[0]
        self.per_px = -1.0 / first
        self.image_gain = np.array(
            [
                (camera.scale_px_per_m + camera.rotation_px_per_rad * slope) / first * shown_of(mode, camera)
                for mode, slope in zip(modes, slopes, strict=True)
            ]
        )
        self.lever = (camera.scale_px_per_m * length_m + camera.rotation_px_per_rad) / first
        self.period_s = 2.0 * pi / self.w_first
