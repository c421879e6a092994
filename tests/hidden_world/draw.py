"""Cases from a seed: arm, sensors, what their owner believes of them, manoeuvres, and what is hidden."""

from dataclasses import replace
from math import pi

import numpy as np

from tests.hidden_world.effects import CAUSES, UNKNOWN, Effect
from tests.hidden_world.rig import TICK_S, Bend, Eye, Feeler, Joint, Rig
from tests.hidden_world.world import EVERY_DAY, Case

Random = np.random.Generator


def draw_case(
    seed: int,
    hidden: str | tuple[str, ...] | None = None,
    size: float | None = None,
    duration_s: float | None = None,
    kept: frozenset[str] = EVERY_DAY,
) -> Case:
    """The case of a seed. hidden: names of causes or unknown effects; size: 0 smallest, 1 largest, on a log scale."""
    random = np.random.default_rng((seed, 31))
    names = (hidden,) if isinstance(hidden, str) else hidden or ()
    rig = _rig(random, names)
    assumed = believed(rig, random)
    duration = float(random.uniform(20.0, 60.0)) if duration_s is None else duration_s
    impacts, damped = bool(random.random() < 0.6), bool(random.random() < 0.35)
    case = Case(seed, rig, assumed, (), round(duration, 3), impacts, damped, kept)
    effects = tuple(
        draw_effect(name, case, np.random.default_rng((seed, 41, place)), size)
        for place, name in enumerate(names)
    )
    return replace(case, effects=effects)


def _rig(random: Random, names: tuple[str, ...]) -> Rig:
    """Any rig. A few effects cannot be on every one: no second bend beside a hidden one, no skew of a triggered
    camera, no step of stamps that are not there."""
    u = random.uniform
    reach = float(u(0.8, 3.0))
    hertz = float(np.exp(u(np.log(1.6), np.log(6.0))))
    share = float(u(1.06, 1.2))
    bends = [Bend(hertz, float(np.exp(u(np.log(0.004), np.log(0.03)))), share)]
    second = Bend(hertz * float(u(5.2, 6.8)), float(u(0.008, 0.03)), 1.0 - share)
    if random.random() < 0.3 and "second_bending_mode" not in names:
        bends.append(second)
    brisk = (2.0 * pi * hertz) ** 2 * 0.008 / (2.0 * share)  # as Rig.root_acceleration of the usual bending
    joint = Joint(
        follow_hertz=float(u(10.0, 35.0)),
        hold_up_s=0.001 * float(random.integers(1, 6)) + 0.0001 * float(random.integers(2, 9)),
        top_speed=float(np.clip(u(0.8, 1.1) * (0.3 * brisk) ** 0.5, 0.15, 0.9)),
        top_acceleration=float(u(15.0, 40.0)),
        encoder_step=2.0 * pi / 2.0 ** int(random.integers(14, 18)),
        encoder_noise=float(np.exp(u(np.log(8e-5), np.log(4e-4)))),
        rate_noise=float(np.exp(u(np.log(0.003), np.log(0.02)))),
        start_angle=float(u(-0.3, 0.3)),
    )
    hiss = float(np.exp(u(np.log(0.03), np.log(0.3))))
    feeler = Feeler(
        gain=-1.0 if random.random() < 0.3 else 1.0,
        lateness_s=float(random.choice([0.0, 0.0, 0.001, 0.002])),
        hiss=hiss,
        bias=float(u(-0.2, 0.2)),
        limit=float(random.choice([19.6, 39.2, 58.8])),
        grain=float(min(0.0098, 0.5 * hiss)),
    )
    rate = float(random.choice([30.0, 50.0, 60.0, 65.0, 70.0, 90.0]))
    free = bool(random.random() < 0.75) or "camera_clock_skew" in names
    stamped = bool(random.random() < 0.35)
    eye = Eye(
        free=free,
        rate=rate,
        open_s=float(u(0.15, 0.9) / rate),
        px_per_m=float(random.choice([-1.0, 1.0]) * u(250.0, 900.0)),
        px_noise=float(np.exp(u(np.log(0.04), np.log(0.25)))),
        centre_px=float(u(-6.0, 6.0)),
        late_s=float(u(0.045, 0.1)),
        late_spread_s=float(u(0.002, 0.0065)),
        slow_part=float(u(0.6, 0.95)),
        slow_s=float(u(0.8, 3.0)),
        phase_s=float(u(0.0, 1.0) / rate),
        stamped=stamped,
        stamp_offset_s=float(u(5.0, 500.0)),
        stamp_ppm=float(u(-40.0, 40.0)),
        counts_exposures=bool(random.random() < 0.6),
    )
    if "camera_clock_skew" in names:  # the stamps come from the clock that runs wrong
        eye = replace(eye, stamp_ppm=0.0)
    return Rig(reach, tuple(bends), joint, feeler, eye, gauge_noise=float(u(2e-5, 2e-4)))


def believed(rig: Rig, random: Random) -> Rig:
    """What the model file says: what it may refit is a little off, what it declares is exact."""
    u = random.uniform
    bends = tuple(
        Bend(b.hertz * float(u(0.98, 1.02)), b.loss * float(u(0.7, 1.3)), b.share * float(u(0.95, 1.05)))
        for b in rig.bends
    )
    feeler = replace(rig.feeler, hiss=rig.feeler.hiss * float(u(0.7, 1.4)), bias=0.0)
    eye = replace(
        rig.eye,
        px_per_m=rig.eye.px_per_m * float(u(0.95, 1.05)),
        px_noise=rig.eye.px_noise * float(u(0.7, 1.4)),
        late_s=rig.eye.late_s * float(u(0.92, 1.08)),
    )
    return replace(rig, bends=bends, feeler=feeler, eye=eye)


def draw_effect(name: str, case: Case, random: Random, size: float | None = None) -> Effect:
    """One hidden thing on a rig, at a size within its physical range (0 to 1, logarithmic; drawn where None)."""
    part = float(random.random()) if size is None else size
    sign = 1.0 if random.random() < 0.5 else -1.0
    luck = int(random.integers(2**31))
    if name in UNKNOWN:
        low, high = UNKNOWN[name]
        extra = {
            "joint_eccentricity": {"turns_per_turn": float(random.integers(20, 60))},
            "aliased_gear_mesh": {"teeth_per_rad": float(random.uniform(2e4, 6e4))},
            "second_axis": {"ratio": float(random.uniform(1.4, 2.3))},
            "loose_mount": {"mount_hz": float(random.uniform(7.0, 12.0))},
            "viscoelastic_creep": {"rate": float(random.uniform(0.3, 2.0))},
        }.get(name, {})
        return Effect(name, {**extra, "amount": low * (high / low) ** part}, luck=luck)
    cause = CAUSES[name]
    departure = cause.smallest * (cause.largest / cause.smallest) ** part
    values = {**_companions(name, case, random), cause.size: 0.0}
    kind = ""
    if name == "clock_step":
        kinds = ["frames", "all"] + (["stamp"] if case.rig.eye.stamped else [])
        kind = str(random.choice(kinds))
    effect = Effect(name, values, luck=luck, kind=kind)
    return sized(effect, case.rig, sign * departure if cause.signed else departure)


def sized(effect: Effect, rig: Rig, departure: float) -> Effect:
    """The effect with its size parameter at a departure from what is neutral on this rig."""
    if effect.name in UNKNOWN:
        return effect.with_value("amount", departure)
    cause = CAUSES[effect.name]
    neutral = _neutral(effect.name, rig)
    value = neutral * (1.0 + departure) if cause.relative else neutral + departure
    if effect.name in ("drive_saturation", "accelerometer_clipping"):
        value = neutral * (1.0 - departure)
    if effect.name == "stale_frame_buffer":
        value = float(max(round(departure), 1))
    if effect.name == "clock_step":
        value = round(departure / TICK_S) * TICK_S
    return effect.with_value(cause.size, value)


def departure_of(effect: Effect, rig: Rig) -> float:
    """The other way round; signed."""
    if effect.name in UNKNOWN:
        return effect["amount"]
    cause = CAUSES[effect.name]
    neutral, value = _neutral(effect.name, rig), effect[cause.size]
    if effect.name in ("drive_saturation", "accelerometer_clipping"):
        return 1.0 - value / neutral
    return value / neutral - 1.0 if cause.relative else value - neutral


def _neutral(name: str, rig: Rig) -> float:
    """The size parameter's value at which nothing is hidden."""
    return {
        "payload_change": 1.0,
        "drive_dead_time": rig.joint.hold_up_s,
        "drive_lag": rig.joint.follow_hertz,
        "drive_saturation": rig.joint.top_speed,
        "accelerometer_clipping": rig.feeler.limit,
        "accelerometer_lag": rig.feeler.lateness_s,
    }.get(name, 0.0)


def _companions(name: str, case: Case, random: Random) -> dict[str, float]:  # noqa: PLR0911 a table of draws
    """Parameters that do not set the size."""
    rig, u = case.rig, random.uniform
    hertz = rig.bends[0].hertz
    if name == "second_bending_mode":
        return {"frequency_hz": hertz * float(u(4.5, 7.0)), "damping_ratio": float(u(0.008, 0.03))}
    if name == "periodic_disturbance":
        ratio = float(u(0.25, 0.75)) if random.random() < 0.4 else float(u(1.35, 4.0))
        return {"frequency_hz": hertz * ratio}
    if name == "mains_hum":
        return {"frequency_hz": float(random.choice([50.0, 60.0]) + u(-0.1, 0.1))}
    if name == "impulse_noise":
        return {"amplitude_m_s2": rig.feeler.hiss * float(u(6.0, 25.0))}
    if name == "delay_bursts":
        return {"duration_s": float(u(0.2, 0.8)), "rate_hz": float(u(0.2, 0.5))}
    if name in ("payload_change", "stale_frame_buffer", "clock_step"):
        return {"onset_s": float(round(case.duration_s * u(0.3, 0.7), 3))}
    return {}
