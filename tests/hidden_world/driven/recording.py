"""A rig with its effect as it is recorded: command and channels, one value a sample."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from tests.hidden_world.driven.dynamics import LINK, LINK_W, MOTOR, MOTOR_W, Laws, Q, V, kinetics
from tests.hidden_world.driven.effects import changed_laws, gear, inertia_changed, sensed
from tests.hidden_world.driven.rig import Channel, Effect, Rig, Values, luck


@dataclass(frozen=True)
class Recording:
    """command: in the drive's own unit. channels: by kind, SI, before they are written in their own units."""

    command: Values
    channels: dict[str, Values]
    states: Values
    step_s: float


def laws_of(rig: Rig) -> Laws:
    """The nominal rig's."""
    drive, drives = rig.drive, rig.excitation
    return Laws(
        gain=drive.gain,
        back_emf=drive.back_emf,
        viscous=drive.viscous,
        lag_s=drive.lag_s,
        limit=drive.limit,
        step=drive.step,
        kp=drives.kp,
        kd=drives.kd,
        closed=float(drives.closed),
    )


def record(rig: Rig, effect: Effect | None = None, noise: bool = True, geared: bool = False) -> Recording:
    """noise: of the channels; the controller of a closed loop has its own in any case.

    geared: motor and link are coupled by the gear's stiffness, without play unless the effect says so.
    """
    laws = laws_of(rig)
    arm, hub, motor = inertia_changed(rig, effect)
    if effect:
        laws = changed_laws(rig, effect, laws)
    if geared or laws.gap > 0.0:
        laws = laws._replace(gear_inertia=motor, **gear(rig))
        matrix = arm.mass_matrix(hub)
    else:
        matrix = arm.mass_matrix(hub + motor)
    chance = luck(rig.seed, 31)
    seen = chance.normal(0.0, 1.0, (rig.rows, 2)) * np.array([2e-5, 2e-3])
    command, states, step = kinetics(
        rig.excitation.values, seen, rig.rate_hz, laws, matrix, arm.damping(), arm.stiffness()
    )
    parts = (len(states) - 1) // rig.rows
    channels = {}
    for number, channel in enumerate(rig.channels):
        values = _true(rig, channel.kind, states, step)
        if effect and effect.channel == channel.kind:
            values, channel = sensed(effect, channel, values, step)  # noqa: PLW2901
        values = values[: rig.rows * parts : parts] + channel.bias
        if noise:
            values = values + _noise(channel, rig.rows, luck(rig.seed, 32, number))
        if channel.quantum > 0.0 and (noise or (effect and effect.cause == "encoder_quantisation")):
            values = np.round(values / channel.quantum) * channel.quantum
        channels[channel.kind] = values
    return Recording(command, channels, states, step)


def record_channel(rig: Rig, kind: str, recording: Recording) -> Values:
    """A channel at each sample, SI, as a perfect sensor would show it."""
    parts = (len(recording.states) - 1) // rig.rows
    return _true(rig, kind, recording.states, recording.step_s)[: rig.rows * parts : parts]


def _true(rig: Rig, kind: str, states: Values, step: float) -> Values:
    """A channel at every step, without what its sensor adds."""
    bends = Q + np.arange(rig.arm.modes)
    if kind == "position":
        return np.asarray(states[:, LINK])
    if kind == "motor_position":
        return np.asarray(rig.drive.gear_ratio * states[:, MOTOR])
    if kind == "velocity":
        return np.asarray(states[:, MOTOR_W])
    if kind in ("deflection", "strain"):
        return np.asarray(np.sum(states[:, bends], axis=1))
    assert kind == "acceleration"
    speed = rig.arm.length_m * states[:, LINK_W] + np.sum(states[:, bends + V - Q], axis=1)
    return np.asarray(np.gradient(speed, step))


def _noise(channel: Channel, rows: int, chance: np.random.Generator) -> Values:
    """Of first order, with the stated deviation."""
    a = channel.colour
    white = chance.normal(0.0, channel.noise * np.sqrt(1.0 - a * a), rows)
    return np.asarray(lfilter([1.0], [1.0, -a], white))
