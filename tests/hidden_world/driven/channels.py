"""Which channels are logged, in which units, with which noise."""

import numpy as np

from tests.hidden_world.driven.effects import SENSOR_CAUSES
from tests.hidden_world.driven.recording import Recording, record_channel
from tests.hidden_world.driven.rig import Channel, Rig, log_uniform

UNITS: dict[str, dict[str, float]] = {
    "position": {"rad": 1.0, "deg": np.pi / 180.0, "counts": 0.0},
    "motor_position": {"rad": 1.0, "deg": np.pi / 180.0, "counts": 0.0},
    "velocity": {"rad/s": 1.0, "deg/s": np.pi / 180.0, "rpm": 2.0 * np.pi / 60.0, "tacho_v": 0.0},
    "deflection": {"m": 1.0, "mm": 1e-3},
    "strain": {"strain_v": 0.0},
    "acceleration": {"m/s2": 1.0, "g": 9.80665},
}
"""SI per unit; 0: the rig's own, drawn."""
_LINES = tuple(4 * n for n in (500, 1000, 1024, 2048, 2500, 4096, 5000, 10000, 25000, 100000, 262144))
_TIPS = ("deflection", "strain", "acceleration")


def choose_channels(
    rig: Rig, plain: Recording, cause: str, chance: np.random.Generator
) -> tuple[Channel, ...]:
    """At least one channel; at least two where a sensor's effect is hidden, and an angle where its step is."""
    angle = "motor_position" if rig.drive.gear_ratio > 1.0 and chance.random() < 0.5 else "position"
    kinds = [angle] if chance.random() < 0.85 or cause == "encoder_quantisation" else []
    if chance.random() < 0.5:
        kinds.append("velocity")
    if rig.arm.modes and chance.random() < 0.65:
        kinds.append(str(chance.choice(_TIPS)))
    if not rig.arm.modes and chance.random() < 0.1:
        kinds.append("acceleration")
    for more in (angle, "velocity"):
        if len(kinds) < (2 if cause in SENSOR_CAUSES else 1) and more not in kinds:
            kinds.append(more)
    return tuple(_channel(rig, plain, kind, cause, chance) for kind in kinds)


def _channel(rig: Rig, plain: Recording, kind: str, cause: str, chance: np.random.Generator) -> Channel:
    """With noise of 0.05 % to 1 % of what the channel shows."""
    values = record_channel(rig, kind, plain)
    deviation = float(np.std(values))
    noise = deviation * log_uniform(chance, 5e-4, 1e-2)
    colour = float(chance.choice([0.0, chance.uniform(0.1, 0.5)]))
    names = list(UNITS[kind])
    if cause == "sensor_scale":
        names = [name for name in names if UNITS[kind][name]] or names
    if cause == "encoder_quantisation" and "position" in kind:
        names.remove("counts")
    unit = str(chance.choice(names))
    size = UNITS[kind][unit]
    quantum = 0.0
    if unit == "counts":
        fine = [n for n in _LINES if 2.0 * np.pi / n < 1.5 * noise]
        size = quantum = 2.0 * np.pi / (fine[0] if fine else _LINES[-1])
        if not fine:
            noise = quantum
    elif size == 0.0:
        size = deviation / log_uniform(chance, 0.3, 3.0)  # a signal of some volts
    bias = 0.0 if "position" in kind else float(chance.choice([0.0, chance.normal(0.0, 3.0 * noise)]))
    if unit in ("rad", "deg") and "position" in kind:
        bias = float(chance.choice([0.0, chance.uniform(-0.2, 0.2)]))
    return Channel(kind, unit, size, noise, colour, bias, quantum)
