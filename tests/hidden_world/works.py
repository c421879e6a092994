"""From a rig and what is hidden in it to the numbers of the compiled motion."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.effects import Effect, rough_ramp, wander
from tests.hidden_world.motion import Works
from tests.hidden_world.rig import FINE, STEP_S, Rig

Array = NDArray[np.float64]


@dataclass
class Inside:
    """The motion's numbers. pitch: factor on the first bend's frequency, and push: its disturbance, m/s^2, both on the
    fine grid or a single value. hold_up: the drive's dead time of each cycle, s. scale_m: a usual bending."""

    works: Works
    pitch: Array
    push: Array
    hold_up: Array
    time: Array
    scale_m: float


def inside(rig: Rig, effects: tuple[Effect, ...], cycles: int, scale_m: float) -> Inside:
    """What moves, with the effects in it."""
    first, joint = rig.bends[0], rig.joint
    second = rig.bends[1] if len(rig.bends) > 1 else None
    works = Works(
        reach=rig.reach,
        w1=2.0 * pi * first.hertz,
        z1=first.loss,
        p1=first.share,
        w2=2.0 * pi * second.hertz if second else 0.0,
        z2=second.loss if second else 0.0,
        p2=second.share if second else 0.0,
        lag=2.0 * pi * joint.follow_hertz,
        top_acceleration=joint.top_acceleration,
        top_speed=joint.top_speed,
    )
    fine = cycles * FINE + 1
    made = Inside(
        works,
        np.ones(1),
        np.zeros(1),
        np.full(cycles, joint.hold_up_s, dtype=np.float64),
        np.arange(fine, dtype=np.float64) * STEP_S,
        scale_m,
    )
    for effect in effects:
        if effect.name in _CHANGES:
            _CHANGES[effect.name](made, effect)
    return made


def moves(effect: Effect) -> bool:
    """Whether it changes the motion, and not only what is measured of it."""
    return effect.name in _CHANGES


def _second_bend(made: Inside, e: Effect) -> None:
    growth = 0.3 * e.detail / made.scale_m
    made.works = made.works._replace(
        w2=2.0 * pi * e["frequency_hz"], z2=e["damping_ratio"], p2=e["participation"], z2_growth=growth
    )


def _dry(made: Inside, e: Effect) -> None:
    speed = 0.05 * made.works.w1 * made.scale_m
    made.works = made.works._replace(dry=e["force_per_mass_m_s2"], dry_excess=0.2 * e.detail, dry_speed=speed)


def _drag2(made: Inside, e: Effect) -> None:
    made.works = made.works._replace(
        drag2=e["coefficient_per_m"],
        drag2_power=2.0 - 0.15 * e.detail,
        drag2_speed=0.5 * made.works.w1 * made.scale_m,
        drag2_skew=0.05 * e.detail,
    )


def _cubic(made: Inside, e: Effect) -> None:
    made.works = made.works._replace(
        cubic=e["coefficient_per_m2"], cubic_soft=e.detail / (3.0 * made.scale_m)
    )


def _payload(made: Inside, e: Effect) -> None:
    closing = 0.15 * e.detail + 1e-9
    risen = np.clip((made.time - e["onset_s"]) / closing, 0.0, 1.0)
    made.pitch = made.pitch * (1.0 + (e["frequency_ratio"] - 1.0) * risen * risen * (3.0 - 2.0 * risen))


def _stiffness(made: Inside, e: Effect) -> None:
    made.pitch = made.pitch * (
        1.0 + rough_ramp(e, made.time, e["frequency_rate_hz_per_s"] * 2.0 * pi / made.works.w1)
    )


def _periodic(made: Inside, e: Effect) -> None:
    random = e.chance()
    phase, beat = random.uniform(0.0, 2.0 * pi, 2)
    turn = 2.0 * pi * e["frequency_hz"] * made.time
    swell = 1.0 + 0.1 * e.detail * np.sin(2.0 * pi * made.time / 7.3 + beat)
    wave = np.sin(turn + phase) + 0.06 * e.detail * np.sin(2.0 * turn + beat)
    made.push = made.push + e["amplitude_m_s2"] * swell * wave


def _dead_time(made: Inside, e: Effect) -> None:
    extra = abs(e["dead_time_s"] - made.hold_up[0])
    jitter = e.chance().uniform(-1.0, 1.0, len(made.hold_up)) * min(0.1 * extra, 0.0002) * e.detail
    made.hold_up = np.maximum(e["dead_time_s"] + jitter, 0.0)


def _lag(made: Inside, e: Effect) -> None:
    """Rough: a tenth of what departs differs between up and down, and a fifth of any delay lies in a quick pole."""
    declared, actual = 1.0 / made.works.lag, 1.0 / (2.0 * pi * e["bandwidth_hz"])
    quick = 0.2 * e.detail * max(actual - declared, 0.0)
    quick = quick if quick > 1e-4 else 0.0
    rate = 1.0 / quick if quick else 0.0
    skew = 0.1 * e.detail * abs(actual - declared) / declared
    made.works = made.works._replace(lag=1.0 / (actual - quick), filter_rate=rate, lag_skew=skew)


def _saturation(made: Inside, e: Effect) -> None:
    made.works = made.works._replace(
        soft_top=e["max_velocity_rad_s"], soft_power=40.0 / e.detail if e.detail else 0.0
    )


def _deadband(made: Inside, e: Effect) -> None:
    width = e["deadband_rad_s"]
    made.works = made.works._replace(
        dead_enter=width * (1.0 - 0.05 * e.detail), dead_leave=width * (1.0 + 0.05 * e.detail)
    )


def _backlash(made: Inside, e: Effect) -> None:
    made.works = made.works._replace(play=e["gap_rad"], teeth_rate=3000.0 / (1.0 + 5.0 * e.detail))


def _friction(made: Inside, e: Effect) -> None:
    loss = e["velocity_loss_rad_s"]
    made.works = made.works._replace(drag=loss, drag_excess=0.3 * e.detail, drag_speed=1.5 * loss)


def _ripple(made: Inside, e: Effect) -> None:
    made.works = made.works._replace(
        ripple=e["amount"], ripple_turns=e["turns_per_turn"], ripple_phase=e.chance().uniform(0.0, 2.0 * pi)
    )


def _hysteresis(made: Inside, e: Effect) -> None:
    made.works = made.works._replace(hysteresis=e["amount"], hysteresis_yield=0.3 * made.scale_m)


def _lean(made: Inside, e: Effect) -> None:
    made.works = made.works._replace(lean=e["amount"])


def _creep(made: Inside, e: Effect) -> None:
    made.works = made.works._replace(creep=e["amount"], creep_rate=e["rate"])


def _gusts(made: Inside, e: Effect) -> None:
    """Wind: two slow random functions, now more and now less."""
    random, count = e.chance(), len(made.time) // 50 + 2
    step = 50 * STEP_S
    force = wander(random, count, 0.4, step) * np.exp(0.7 * wander(random, count, 4.0, step))
    made.push = made.push + e["amount"] * np.interp(made.time, np.arange(count) * step, force)


_CHANGES: dict[str, Callable[[Inside, Effect], None]] = {
    "second_bending_mode": _second_bend,
    "coulomb_damping": _dry,
    "quadratic_damping": _drag2,
    "cubic_stiffness": _cubic,
    "payload_change": _payload,
    "stiffness_drift": _stiffness,
    "periodic_disturbance": _periodic,
    "drive_dead_time": _dead_time,
    "drive_lag": _lag,
    "drive_saturation": _saturation,
    "drive_deadband": _deadband,
    "gear_backlash": _backlash,
    "joint_friction": _friction,
    "joint_eccentricity": _ripple,
    "bouc_wen_hysteresis": _hysteresis,
    "asymmetric_stiffness": _lean,
    "viscoelastic_creep": _creep,
    "gusts": _gusts,
}
