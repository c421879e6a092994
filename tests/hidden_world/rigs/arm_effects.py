"""How effects of the arm and of the drive enter the equations: one function a cause, each in several forms.

A size is relative where a rig gives a scale: to the bending `scale_m` that its moves bring about, to its fastest
command.
"""

from collections.abc import Callable

import numpy as np

from tests.hidden_world.rigs.course import course, wander
from tests.hidden_world.rigs.inputs import Inputs, scale_m
from tests.hidden_world.rigs.rig import FINE, STEP_S, TICK_S, Effect, Rig, Values, luck

Change = Callable[[Inputs, Effect, Rig], None]


def change(inputs: Inputs, effects: tuple[Effect, ...], rig: Rig) -> Inputs:
    """Inputs as the effects leave them; those of sensors are passed over."""
    for effect in effects:
        if effect.cause in CHANGES:
            CHANGES[effect.cause](inputs, effect, rig)
    return inputs


def _after(effect: Effect, time_s: Values) -> Values:
    return np.asarray(time_s >= effect.onset_s, float)


def _cycles_s(rig: Rig) -> Values:
    return np.arange(rig.cycles) * TICK_S


def _w(inputs: Inputs) -> float:
    return float(inputs.modes[0, 0])


def second_bending_mode(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: participation."""
    row = [_w(inputs) * effect.extras["ratio"], effect.extras["damping_ratio"], effect.sign * effect.size]
    row.append(1.0 if effect.form == "struck_too" else 0.0)
    inputs.modes = np.insert(inputs.modes, 1, row, axis=0)


def coulomb_damping(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: over the acceleration of the usual bending."""
    force = coulomb_force(rig, effect)
    speed = scale_m(rig) * _w(inputs)
    width = max((1e-3 if effect.form == "sharp" else 0.03) * speed, 2.0 * force * STEP_S)
    inputs.laws = inputs.laws._replace(coulomb=force, coulomb_width=width, arm_from_s=effect.onset_s)


def coulomb_force(rig: Rig, effect: Effect) -> float:
    """m/s^2."""
    return effect.size * scale_m(rig) * (2.0 * np.pi * rig.modes[0].frequency_hz) ** 2


def quadratic_damping(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: coefficient times the usual bending. The power is extras["power"]; equal forces at the usual speed."""
    power, usual = effect.extras["power"], scale_m(rig) * _w(inputs)
    c = effect.size / scale_m(rig) * usual ** (2.0 - power)
    inputs.laws = inputs.laws._replace(power_damping=c, power=power, arm_from_s=effect.onset_s)


def cubic_stiffness(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: relative change of the stiffness at the usual bending."""
    c = effect.sign * effect.size / scale_m(rig) ** 2
    fifth = effect.extras.get("fifth", 0.0) * c / scale_m(rig) ** 2
    inputs.laws = inputs.laws._replace(cubic=c, fifth=fifth, arm_from_s=effect.onset_s)


def payload_change(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: relative change of the frequency."""
    t = _cycles_s(rig)
    rise = 0.0 if effect.form == "abrupt" else 0.3
    share = np.clip((t - effect.onset_s) / rise, 0.0, 1.0) if rise else _after(effect, t)
    ratio = 1.0 + effect.sign * effect.size * share
    inputs.stiff = inputs.stiff * ratio**2
    if effect.form == "mass":  # a force moves a heavier tip less; the same dashpot damps it less
        inputs.damp = inputs.damp * ratio
        fine = np.arange(len(inputs.force)) * 0.5 * STEP_S
        inputs.force = inputs.force * np.interp(fine, t, ratio) ** 2


def stiffness_drift(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: relative change of the frequency by the end."""
    grown = course(effect.form, _cycles_s(rig), effect.onset_s, effect.seed)
    inputs.stiff = inputs.stiff * (1.0 + effect.sign * effect.size * grown) ** 2


def periodic_disturbance(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: force over that of the usual bending."""
    t = np.arange(len(inputs.force)) * 0.5 * STEP_S
    chance = luck(effect.seed, 31)
    phase = 2.0 * np.pi * effect.extras["frequency_hz"] * t + chance.uniform(0.0, 2.0 * np.pi)
    if effect.form == "wandering_phase":
        phase = phase + 0.6 * wander(t, 6.0, chance)
    wave = np.sin(phase)
    if effect.form == "two_tones":
        wave = wave + 0.3 * np.sin(2.0 * phase + 0.7)
    inputs.force = inputs.force + coulomb_force(rig, effect) * wave * _after(effect, t)


def drive_dead_time(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: s."""
    t = np.arange(rig.steps) * STEP_S
    extra = np.full(rig.steps, effect.size / STEP_S)
    if effect.form == "jitter":
        extra = extra * np.repeat(
            np.clip(1.0 + 0.3 * luck(effect.seed, 32).normal(size=rig.cycles), 0.0, 2.0), FINE
        )
    inputs.late_steps = inputs.late_steps + extra * _after(effect, t)


def drive_lag(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: by how much longer the time constant is, relative."""
    laws = inputs.laws
    if effect.form == "second_pole":
        inputs.laws = laws._replace(second_lag=laws.lag_up / effect.size)
    else:
        slow = laws.lag_up / (1.0 + effect.size)
        inputs.laws = laws._replace(
            lag_up=slow, lag_down=laws.lag_down if effect.form == "speeding_up" else slow
        )


def drive_saturation(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: by how much what is asked exceeds the limit, relative."""
    if effect.form.startswith("acceleration"):
        limit = saturation_limit(effect)
        one_way = effect.form == "acceleration_by_direction"
        up = limit if not one_way or effect.sign > 0 else inputs.laws.most_up
        down = limit if not one_way or effect.sign < 0 else inputs.laws.most_down
        inputs.laws = inputs.laws._replace(most_up=up, most_down=down)
        return
    limit = saturation_limit(effect)
    low = -limit if effect.form == "velocity" or effect.sign < 0 else -np.inf
    high = limit if effect.form == "velocity" or effect.sign > 0 else np.inf
    inputs.obeyed = np.clip(inputs.obeyed, low, high)


def saturation_limit(effect: Effect) -> float:
    """rad/s, or rad/s^2."""
    return effect.extras["peak"] / (1.0 + effect.size)


def drive_deadband(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: over the fastest command. Commands within the band are zero, others pass unchanged."""
    band, u = effect.size * rig.fastest_rad_s, inputs.obeyed
    dead = np.abs(u) < band
    if effect.form == "hysteretic":  # once it moves, it goes on down to 0.7 of the band
        dead &= ~_latched(np.abs(u[::FINE]), band, 0.7 * band)
    fresh = _after(effect, np.arange(rig.steps) * STEP_S) > 0.0
    inputs.obeyed = np.where(dead & fresh, 0.0, u)


def _latched(x: Values, on: float, off: float) -> Values:
    state, out = False, np.zeros(len(x), bool)
    for k, value in enumerate(x.tolist()):
        state = value >= on or (state and value >= off)
        out[k] = state
    return np.repeat(out, FINE)


def gear_backlash(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: gap, rad."""
    hard = effect.form == "impact"
    w = 2.0 * np.pi * (90.0 if hard else 70.0)
    damping, drag = (2.0 * 0.15 * w, 2.0) if hard else (2.0 * 0.8 * w, 200.0)
    inputs.laws = inputs.laws._replace(
        gap=effect.size, gear_stiffness=w * w, gear_damping=damping, gear_drag=drag
    )


def joint_friction(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: velocity that is lost, over the fastest command."""
    loss = effect.size * rig.fastest_rad_s
    t = np.arange(rig.steps) * STEP_S
    if effect.form == "velocity_loss":
        less = np.sign(inputs.obeyed) * np.maximum(np.abs(inputs.obeyed) - loss, 0.0)
        inputs.obeyed = np.where(t >= effect.onset_s, less, inputs.obeyed)
        return
    grip = loss * inputs.laws.lag_up
    more = 0.4 if effect.form == "stiction" else 0.0
    other = effect.extras.get("other_way", 1.0) if effect.form == "by_direction" else 1.0
    up, down = (grip, other * grip) if effect.sign > 0 else (other * grip, grip)
    inputs.laws = inputs.laws._replace(
        friction_up=up,
        friction_down=down,
        stiction=more,
        stiction_width=max(0.3 * loss, 1e-4),
        friction_width=max(0.02 * loss, grip * STEP_S),
        friction_from_s=effect.onset_s,
    )


def asymmetric_stiffness(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: by how much the two sides differ from their mean, relative."""
    inputs.laws = inputs.laws._replace(side_step=effect.sign * effect.size)


def bouc_wen_hysteresis(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: share of the stiffness that is hysteretic."""
    inputs.laws = inputs.laws._replace(
        hysteresis=effect.size,
        hysteresis_m=effect.extras["width"] * scale_m(rig),
        hysteresis_power=effect.extras["power"],
    )


def cross_axis_coupling(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: coupling, over the stiffness, both ways."""
    inputs.laws = inputs.laws._replace(
        side_w=effect.extras["ratio"] * _w(inputs),
        side_z=effect.extras["damping_ratio"],
        side_from_bending=effect.size,
        side_back=effect.size,
    )


def torsion_in_image(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """The joint's acceleration twists the tip; only the camera sees it (camera_effects.py)."""
    inputs.laws = inputs.laws._replace(
        side_w=effect.extras["ratio"] * _w(inputs),
        side_z=effect.extras["damping_ratio"],
        side_from_joint=rig.length_m,
    )


def loose_camera_mount(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """The mount rings; only the image moves with it (camera_effects.py)."""
    inputs.laws = inputs.laws._replace(
        mount_w=2.0 * np.pi * effect.extras["frequency_hz"], mount_z=effect.extras["damping_ratio"]
    )


def centrifugal_softening(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: relative loss of stiffness at the fastest command."""
    inputs.laws = inputs.laws._replace(centrifugal=-effect.size / rig.fastest_rad_s**2)


def stop_contact(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: stiffness of the stop over the arm's. It stands at extras["at"] of the usual bending."""
    inputs.laws = inputs.laws._replace(stop_m=effect.extras["at"] * scale_m(rig), stop_stiffness=effect.size)


def drive_gain_by_direction(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: relative difference."""
    inputs.obeyed = inputs.obeyed * (1.0 + effect.sign * effect.size * np.sign(inputs.obeyed))


def random_tip_force(inputs: Inputs, effect: Effect, rig: Rig) -> None:
    """size: deviation over the force of the usual bending; correlated over a period of the arm."""
    t = np.arange(len(inputs.force)) * 0.5 * STEP_S
    gust = wander(t, effect.extras["time_s"], luck(effect.seed, 33))
    inputs.force = inputs.force + coulomb_force(rig, effect) * gust * _after(effect, t)


CHANGES: dict[str, Change] = {
    f.__name__: f
    for f in (
        second_bending_mode,
        coulomb_damping,
        quadratic_damping,
        cubic_stiffness,
        payload_change,
        stiffness_drift,
        periodic_disturbance,
        drive_dead_time,
        drive_lag,
        drive_saturation,
        drive_deadband,
        gear_backlash,
        joint_friction,
        asymmetric_stiffness,
        bouc_wen_hysteresis,
        cross_axis_coupling,
        torsion_in_image,
        loose_camera_mount,
        centrifugal_softening,
        stop_contact,
        drive_gain_by_direction,
        random_tip_force,
    )
}
