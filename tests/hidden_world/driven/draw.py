"""Rigs from a seed: arms, drives, channels, excitations as laboratories have them."""

from dataclasses import replace

import numpy as np

from tests.hidden_world.driven.channels import choose_channels
from tests.hidden_world.driven.effects import Scales
from tests.hidden_world.driven.excitation import CLOSED, OPEN, shape
from tests.hidden_world.driven.recording import Recording, record
from tests.hidden_world.driven.rig import Arm, Drive, Excitation, Rig, log_uniform, luck

RATES_HZ = (50.0, 100.0, 200.0, 250.0, 500.0, 1000.0)
KINDS = ("torque", "current", "voltage")
_LEAST_SAMPLES_A_PERIOD = 4.0
_SLOWEST_CLOSED_HZ = 200.0
_FASTEST_RAD_S = 8.0


def draw_rig(seed: int, cause: str, attempt: int = 0, longest_s: float = 60.0) -> tuple[Rig, Scales]:
    """A rig on which the cause may be hidden, and what it does without. Raises RuntimeError where none is found."""
    for turn in range(20):
        chance = luck(seed, 1, attempt, turn)
        rig = _draw(seed, cause, chance, longest_s)
        if rig is None:
            continue
        tried = _excited(rig, chance)
        if tried is None:
            continue
        rig, plain = tried
        rig = replace(rig, channels=choose_channels(rig, plain, cause, chance))
        return rig, scales_of(rig, plain)
    raise RuntimeError(f"case {seed}: no rig for {cause} in 20 draws")


def scales_of(rig: Rig, plain: Recording) -> Scales:
    """What the effects' sizes are relative to."""
    angle, speed = plain.states[:, 0], plain.states[:, 1]
    torque = rig.drive.gain * plain.command
    return Scales(
        float(np.std(torque)),
        float(np.std(speed)),
        float(np.std(plain.command)),
        float(np.std(angle)),
        float(np.max(np.abs(plain.command))),
    )


def _draw(seed: int, cause: str, chance: np.random.Generator, longest_s: float) -> Rig | None:
    """Arm, drive, rate; the excitation of unit size, no channel yet. None: the modes are too quick for any rate."""
    modes = int(chance.choice([0, 1, 2], p=[0.4, 0.35, 0.25]))
    first = log_uniform(chance, 1.5, 12.0)
    ratios = (1.0, 6.267 * chance.uniform(0.97, 1.03))
    arm = Arm(
        length_m=log_uniform(chance, 0.2, 1.5),
        mass_kg=log_uniform(chance, 0.05, 3.0),
        frequencies_hz=tuple(first * r for r in ratios[:modes]),
        damping_ratios=tuple(log_uniform(chance, 0.004, 0.04) for _ in range(modes)),
    )
    if chance.random() < 0.3:
        arm = replace(arm, payload_kg=arm.mass_kg * chance.uniform(0.1, 0.5))
    drive = _drive(arm, cause, chance)
    quickest = highest_hz(arm, drive)
    rates = [r for r in RATES_HZ if r >= _LEAST_SAMPLES_A_PERIOD * quickest]
    if not rates:
        return None
    rate = float(chance.choice(rates))
    duration = min(float(round(chance.uniform(10.0, 60.0 if rate < 700.0 else 30.0), 1)), longest_s)
    top = min(rate / 6.0, log_uniform(chance, 1.0, 5.0) if modes == 0 else 1.4 * lowest_hz(arm, drive))
    closed = rate >= _SLOWEST_CLOSED_HZ and chance.random() < 0.4
    kind = str(chance.choice(CLOSED if closed else OPEN))
    values = shape(kind, round(rate * duration), rate, min(top, 1.0) if closed else top, chance)
    excitation = Excitation(kind, values, closed)
    if closed:
        w = 2.0 * np.pi * (log_uniform(chance, 0.6, 2.0) if modes == 0 else first * chance.uniform(0.25, 0.6))
        total = arm.rigid_inertia + drive.hub_inertia + drive.motor_inertia
        excitation = replace(
            excitation,
            kp=total * w * w / drive.gain,
            kd=max(1.6 * w * total - drive.viscous, 0.0) / drive.gain,
        )
    stated = bool(chance.random() < 0.6)
    return Rig(seed, rate, duration, arm, drive, (), excitation, 1.0, stated)


def _drive(arm: Arm, cause: str, chance: np.random.Generator) -> Drive:
    """With friction that stops the joint within 0.15 to 2 s. The command's limit and resolution come later."""
    kind = str(chance.choice(KINDS))
    ratio = 1.0
    if cause == "gear_backlash" or chance.random() < 0.45:
        ratio = float(chance.choice([3.7, 5.0, 14.0, 25.0, 50.0, 100.0]))
    turning = arm.rigid_inertia * log_uniform(chance, 0.3, 3.0)
    motor = turning * (chance.uniform(0.3, 0.9) if ratio > 1.0 else chance.uniform(0.1, 0.5))
    lost = (turning + arm.rigid_inertia) / log_uniform(chance, 0.15, 2.0)
    constant = log_uniform(chance, 0.02, 0.3)  # N m / A, of the motor
    back = lost * chance.uniform(0.3, 0.8) if kind == "voltage" else 0.0
    gain = {"torque": 1.0, "current": ratio * constant, "voltage": back / (ratio * constant)}[kind]
    return Drive(
        kind=kind,
        gain=gain,
        back_emf=back,
        viscous=lost - back,
        hub_inertia=turning - motor,
        motor_inertia=motor,
        gear_ratio=ratio,
        lag_s=float(chance.choice([0.0, log_uniform(chance, 8e-4, 5e-3)])),
        limit=1e12,
        log_unit=_log_unit(cause, chance),
        log_size=1.0,
    )


def _log_unit(cause: str, chance: np.random.Generator) -> str:
    """Inertia and friction against what is stated can only be told where the command's unit is known."""
    unit = str(chance.choice(["si", "counts", "percent"], p=[0.5, 0.25, 0.25]))
    return "si" if cause in ("inertia_change", "joint_viscous_friction") else unit


def _excited(rig: Rig, chance: np.random.Generator) -> tuple[Rig, Recording] | None:
    """The rig with an excitation of the size that a laboratory uses; None where its loop is not stable."""
    unit = record(rig, noise=False)
    reach, quick = float(np.max(np.abs(unit.states[:, 0]))), float(np.std(unit.states[:, 1]))
    if not np.isfinite(reach) or reach <= 0.0 or (rig.excitation.closed and reach > 2.5):
        return None
    size = min(log_uniform(chance, 0.3, 2.5) / reach, _FASTEST_RAD_S / quick)
    peak = size * float(np.max(np.abs(unit.command)))
    limit = peak * chance.uniform(1.2, 2.0)
    full = {"si": 1.0, "counts": float(chance.choice([2047.0, 32767.0])), "percent": 100.0}[
        rig.drive.log_unit
    ]
    log_size = 1.0 if rig.drive.log_unit == "si" else limit / full
    drive = replace(
        rig.drive,
        limit=limit,
        log_size=log_size,
        step=log_size if rig.drive.log_unit == "counts" else 0.0,
    )
    excitation = replace(rig.excitation, values=size * rig.excitation.values)
    rig = replace(rig, drive=drive, excitation=excitation, speed=size * quick)
    return rig, record(rig, noise=False)


def _frequencies(arm: Arm, drive: Drive) -> np.ndarray:
    """Of the arm on its free hub, Hz, ascending, without the rigid mode."""
    if not arm.modes:
        return np.zeros(0)
    stiffness = np.diag([0.0, *arm.stiffness()])
    squares = np.linalg.eigvals(
        np.linalg.solve(arm.mass_matrix(drive.hub_inertia + drive.motor_inertia), stiffness)
    )
    return np.asarray(np.sqrt(np.sort(np.real(squares))[1:]) / (2.0 * np.pi))


def highest_hz(arm: Arm, drive: Drive) -> float:
    return float(max(_frequencies(arm, drive), default=1.0))


def lowest_hz(arm: Arm, drive: Drive) -> float:
    return float(min(_frequencies(arm, drive), default=1.0))
