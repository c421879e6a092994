"""A joint with a flexible arm under a torque, from its mass matrix, by scipy: apart from the program's own.

J theta'' + sum m_i b_i q_i'' = tau - d theta',    b_i theta'' + q_i'' = - 2 zeta_i w_i q_i' - w_i^2 q_i
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from stillarm.common.files.model import Model

Array = NDArray[np.float64]


class TorqueArm:
    """The true motion, cycle by cycle, of a model whose joint a torque drives behind an amplifier with a lag."""

    def __init__(self, model: Model) -> None:
        arm, drive = model.arm, model.drive
        self.cycle_s = model.timing.cycle_s
        self._follows = np.array([one.participation * arm.length_m for one in arm.modes])
        self._mass = np.array([one.modal_mass_kg for one in arm.modes])
        self._w = 2.0 * np.pi * np.array([one.frequency_hz for one in arm.modes])
        self._zeta = np.array([one.damping_ratio for one in arm.modes])
        self._inertia, self._viscous, self._lag = (
            drive.inertia_kg_m2,
            drive.viscous_n_m_s,
            drive.amplifier_lag_s,
        )
        m = len(arm.modes)
        self.state: Array = np.zeros(3 + 2 * m)  # theta, theta', tau, q_i, q_i'
        self._matrix = np.eye(1 + m)
        self._matrix[0, 0] = self._inertia
        self._matrix[0, 1:] = self._mass * self._follows
        self._matrix[1:, 0] = self._follows
        n = len(self.state)
        free = np.stack([self.derivative(column, 0.0) for column in np.eye(n)], axis=1)
        whole = np.zeros((n + 1, n + 1))
        whole[:n, :n], whole[:n, n] = free, self.derivative(np.zeros(n), 1.0)
        step = expm(whole * self.cycle_s)
        self._moved, self._pushed = step[:n, :n], step[:n, n]

    def derivative(self, state: Array, torque: float) -> Array:
        m = len(self._w)
        q, v = state[3 : 3 + m], state[3 + m :]
        bent = 2.0 * self._zeta * self._w * v + self._w**2 * q
        accelerations = np.linalg.solve(self._matrix, [state[2] - self._viscous * state[1], *-bent])
        return np.array([state[1], accelerations[0], (torque - state[2]) / self._lag, *v, *accelerations[1:]])

    def advance(self, torque: float) -> None:
        """By the matrix exponential: the equations are linear, and the torque is held over the cycle."""
        self.state = self._moved @ self.state + self._pushed * torque
