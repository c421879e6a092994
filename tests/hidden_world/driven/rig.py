"""What one recording is made of: arm, drive, channels, excitation. SI units; the drive is referred to the joint."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

PARTICIPATIONS = (1.1378, -0.1815)
"""Of a uniform clamped-free beam's modes, scaled to 1 at the tip: integral of x phi over length * integral of phi^2.
Blevins, Formulas for Natural Frequency and Mode Shape, 1979, table 8-1: phi = cosh - cos - sigma (sinh - sin)."""
MODAL_MASS = 0.25
"""Of the beam's mass, for each of these modes."""


@dataclass(frozen=True)
class Arm:
    """A uniform beam, by the shapes of its clamped-free modes; no modes: a rigid bar.

    frequencies_hz, damping_ratios: with a clamped joint and no payload. payload_kg: a point mass at the tip.
    """

    length_m: float
    mass_kg: float
    frequencies_hz: tuple[float, ...]
    damping_ratios: tuple[float, ...]
    payload_kg: float = 0.0

    @property
    def modes(self) -> int:
        return len(self.frequencies_hz)

    @property
    def rigid_inertia(self) -> float:
        """About the joint, with the payload, kg m^2."""
        return (self.mass_kg / 3.0 + self.payload_kg) * self.length_m**2

    def mass_matrix(self, inertia: float) -> Values:
        """M of M x'' + C x' + K x = torque, x = (joint angle, tip deflection of each mode).

        inertia: what turns beside the arm, kg m^2.
        """
        n, m = self.modes, MODAL_MASS * self.mass_kg
        matrix = np.diag([inertia + self.mass_kg / 3.0 * self.length_m**2, *[m] * n])
        coupling = m * self.length_m * np.array(PARTICIPATIONS[:n])
        matrix[0, 1:], matrix[1:, 0] = coupling, coupling
        tip = np.array([self.length_m, *[1.0] * n])
        return np.asarray(matrix + self.payload_kg * np.outer(tip, tip))

    def stiffness(self) -> Values:
        """K's diagonal for the modes, N/m."""
        w = 2.0 * np.pi * np.array(self.frequencies_hz)
        return np.asarray(MODAL_MASS * self.mass_kg * w**2)

    def damping(self) -> Values:
        """C's diagonal for the modes, N s/m."""
        w = 2.0 * np.pi * np.array(self.frequencies_hz)
        return np.asarray(2.0 * np.array(self.damping_ratios) * MODAL_MASS * self.mass_kg * w)

    def clamped_modes(self) -> list[dict[str, float]]:
        """Joint clamped, payload on, ascending: q'' + 2 z w q' + w^2 q = -participation * length * theta''."""
        if not self.modes:
            return []
        matrix = self.mass_matrix(1.0)
        mass, coupling = matrix[1:, 1:], matrix[0, 1:]
        squares, shapes = np.linalg.eig(np.linalg.solve(mass, np.diag(self.stiffness())))
        out = []
        for k in np.argsort(squares):
            shape = shapes[:, k] / np.sum(shapes[:, k])
            own, w = float(shape @ mass @ shape), float(np.sqrt(squares[k]))
            lost = float(shape @ np.diag(self.damping()) @ shape)
            out.append(
                {
                    "frequency_hz": w / (2.0 * np.pi),
                    "damping_ratio": lost / (2.0 * w * own),
                    "participation": float(shape @ coupling) / (own * self.length_m),
                    "modal_mass_kg": own,
                }
            )
        return out


@dataclass(frozen=True)
class Drive:
    """kind: torque, current or voltage: what the command is. torque = gain * command - back_emf * velocity.

    gain: N m per N m, A or V. viscous, back_emf: N m s. motor_inertia: kg m^2, referred to the joint by gear_ratio^2.
    lag_s: of the amplifier, first order. limit: of the command. log_unit: how the command is logged; log_size: command
    per logged unit. step: resolution of the command, 0 for none.
    """

    kind: str
    gain: float
    back_emf: float
    viscous: float
    hub_inertia: float
    motor_inertia: float
    gear_ratio: float
    lag_s: float
    limit: float
    log_unit: str
    log_size: float
    step: float = 0.0


@dataclass(frozen=True)
class Channel:
    """What is logged: position, motor_position, velocity, deflection, strain or acceleration (of the tip).

    unit: as logged; size: SI (strain: of deflection, m) per logged unit. noise, bias, quantum: SI. colour: the share
    of the noise that a sample hands to the next.
    """

    kind: str
    unit: str
    size: float
    noise: float
    colour: float = 0.0
    bias: float = 0.0
    quantum: float = 0.0


@dataclass(frozen=True)
class Excitation:
    """kind: multisine, ... ; values: of the command, or where closed of the angle asked for.

    closed: command = kp (value - angle) - kd velocity, with kp in command / rad.
    """

    kind: str
    values: Values
    closed: bool = False
    kp: float = 0.0
    kd: float = 0.0


@dataclass(frozen=True)
class Rig:
    """A rig and its experiment. speed: rms of the joint's velocity in the plain rig, rad/s.

    stated: whoever hands the recording over states the nominal rig with it.
    """

    seed: int
    rate_hz: float
    duration_s: float
    arm: Arm
    drive: Drive
    channels: tuple[Channel, ...]
    excitation: Excitation
    speed: float
    stated: bool

    @property
    def rows(self) -> int:
        return round(self.rate_hz * self.duration_s)

    @property
    def inertia(self) -> float:
        """All that turns, arm taken as rigid, kg m^2."""
        return self.arm.rigid_inertia + self.drive.hub_inertia + self.drive.motor_inertia


@dataclass(frozen=True)
class Effect:
    """What is hidden. size: by effects.py; channel: the one that a sensor's effect concerns; chance: two numbers in
    0..1 that give the form its details."""

    cause: str
    form: str
    size: float
    sign: float = 1.0
    channel: str = ""
    chance: tuple[float, float] = (0.5, 0.5)


def luck(seed: int, *what: int) -> np.random.Generator:
    """Numbers of one purpose from a case's seed."""
    return np.random.default_rng((seed, *what))


def log_uniform(chance: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(chance.uniform(np.log(low), np.log(high))))
