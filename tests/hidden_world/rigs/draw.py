"""A rig from a seed, and an effect for it: far more varied than any one of them is likely."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from tests.hidden_world.rigs.catalogue import ALL
from tests.hidden_world.rigs.recording import Recording
from tests.hidden_world.rigs.rig import (
    STEP_S,
    Accelerometer,
    Arrival,
    Camera,
    Drive,
    Effect,
    Encoder,
    Mode,
    Nuisance,
    Rig,
    log_uniform,
    luck,
)

_BEAM = (1.14, -0.18, 0.065)
_MOST_BENDING = 0.03  # of the length
_MOST_TIP_M_S2 = 50.0


def draw_rig(seed: int, needs: Iterable[str] = (), one_mode: bool = False) -> Rig:
    """The rig of a seed. needs: what it must have, "accelerometer", "stamps" or "freerun". one_mode: no second one."""
    chance = luck(seed, 11)
    duration = float(round(chance.uniform(20.0, 70.0), 1))
    f, length = log_uniform(chance, 0.8, 12.0), log_uniform(chance, 0.5, 4.0)
    modes = _modes(chance, f, one_mode)
    camera = _camera(chance, f, set(needs))
    bandwidth = max(log_uniform(chance, 5.0, 50.0), 1.2 * f)
    w, reach = 2.0 * np.pi * f, abs(modes[0].participation) * length
    seen = float(chance.uniform(150.0, 800.0)) / abs(camera.scale_px_per_m * length)
    farthest = float(np.clip(seen, 0.03, 0.8))
    fastest = min(_MOST_BENDING * length * w / reach, _MOST_TIP_M_S2 / (reach * w), farthest / 0.3, 2.5)
    fastest *= log_uniform(chance, 0.4, 1.0)
    hardest = 2.0 * np.pi * bandwidth * fastest  # a step to the fastest command
    tight = chance.random() < 0.15
    drive = Drive(
        bandwidth,
        float(round(chance.choice([chance.integers(0, 9), chance.uniform(0.0, 8.0)]), 1)) * 1e-3,
        fastest * float(chance.uniform(1.1, 2.0)),
        hardest * float(chance.uniform(0.4, 0.9) if tight else chance.uniform(2.2, 4.0)),
    )
    encoder = None
    if chance.random() < 0.75:
        noise = log_uniform(chance, 5e-6, 2e-4)
        coarse = chance.random() < 0.3
        encoder = Encoder(
            noise if not coarse else 0.1 * noise,
            log_uniform(chance, 5e-4, 1e-2),
            2.0 * noise if coarse else 0.0,
            bool(chance.random() < 0.15),
        )
    accelerometer = None
    if "accelerometer" in needs or chance.random() < 0.88:
        accelerometer = Accelerometer(
            float(chance.choice([1.0, 1.0, 1.0, -1.0])),
            log_uniform(chance, 0.02, 1.0),
            float(chance.choice([0.0, chance.normal(0.0, 0.08)])),
            19.6,
            _colour(chance),
        )
    swinging = chance.random() < 0.2
    usual = reach * fastest / w
    return Rig(
        seed,
        duration,
        length,
        modes,
        drive,
        encoder,
        accelerometer,
        camera,
        _arrival(chance, camera),
        _nuisance(chance, modes, one_mode),
        swinging_m=usual * float(chance.uniform(0.1, 0.8)) if swinging else 0.0,
        swinging_phase=float(chance.uniform(0.0, 2.0 * np.pi)),
        farthest_rad=farthest,
        fastest_rad_s=fastest,
    )


def _modes(chance: np.random.Generator, f: float, one_mode: bool) -> tuple[Mode, ...]:
    near = chance.random() < 0.5
    first = float(chance.uniform(1.05, 1.25) if near else chance.uniform(0.9, 1.65))
    modes = [Mode(f, log_uniform(chance, 0.001, 0.04), first)]
    count = 1 if one_mode else int(chance.choice([1, 2, 3], p=[0.5, 0.3, 0.2]))
    ratios = (1.0, float(chance.uniform(4.5, 7.0)), float(chance.uniform(13.0, 18.5)))
    for k in range(1, count):
        frequency = f * ratios[k]
        if frequency > 160.0:
            break
        share = _BEAM[k] * float(chance.uniform(0.85, 1.15) if near else chance.uniform(0.3, 1.5))
        modes.append(
            Mode(frequency, log_uniform(chance, 0.002, 0.02), share, float(chance.uniform(0.6, 1.0)))
        )
    return tuple(modes)


def _colour(chance: np.random.Generator) -> float:
    return float(chance.uniform(0.05, 0.4)) if chance.random() < 0.35 else 0.0


def _camera(chance: np.random.Generator, f: float, needs: set[str]) -> Camera:
    triggered = "freerun" not in needs and chance.random() < 0.2
    rate = float(round(log_uniform(chance, max(25.0, 4.5 * f), 120.0)))
    exposure = float(chance.uniform(0.1, 0.85)) / rate
    stamped = "stamps" in needs or chance.random() < 0.45
    return Camera(
        triggered,
        rate,
        exposure,
        float(chance.uniform(0.05, 0.5)) / rate,
        log_uniform(chance, 100.0, 1500.0) * float(chance.choice([1.0, -1.0])),
        log_uniform(chance, 5.0, 100.0) * float(chance.choice([1.0, -1.0]))
        if chance.random() < 0.15
        else 0.0,
        float(chance.choice([0.0, chance.uniform(-30.0, 30.0)])),
        log_uniform(chance, 0.02, 0.3),
        _colour(chance),
        bool(stamped),
        float(chance.uniform(-100.0, 100.0)),
        float(chance.normal(0.0, 60.0)),
        log_uniform(chance, 1e-6, 3e-5),
        float(chance.choice([1e-6, 1e-6, 1e-4])),
        bool(chance.random() < 0.6),
    )


def _arrival(chance: np.random.Generator, camera: Camera) -> Arrival:
    least = 0.5 * camera.exposure_s + camera.readout_s + 0.004
    std = log_uniform(chance, 1e-3, min(10e-3, 0.6 / camera.frame_rate_hz))
    return Arrival(
        max(log_uniform(chance, 0.03, 0.15), least + 3.0 * std),
        std,
        float(chance.uniform(0.1, 0.7)),
        log_uniform(chance, 2.0, 20.0),
        bool(chance.random() < 0.4),
        str(chance.choice(["latest", "next"])),
        float(chance.choice([1e-3, 1e-3, 1e-4])),
    )


def _nuisance(chance: np.random.Generator, modes: tuple[Mode, ...], above: bool) -> Nuisance:
    """above: the extra mode lies beyond where a second one may be hidden."""
    if chance.random() < 0.2:
        return Nuisance()
    third = None
    low, high = (8.0, 14.0) if above else (2.6, 6.0)
    frequency = min(modes[-1].frequency_hz * float(chance.uniform(low, high)), 170.0)
    if chance.random() < 0.5 and len(modes) < 3 and frequency > 2.5 * modes[-1].frequency_hz:
        third = Mode(frequency, 0.008, -0.02, 0.0)
    return Nuisance(
        third,
        float(chance.uniform(0.0, 0.1)) if chance.random() < 0.6 else 0.0,
        float(chance.uniform(5.0, 25.0)),
        float(chance.normal(0.0, 0.003)) if chance.random() < 0.6 else 0.0,
    )


def draw_effect(cause: str, rig: Rig, plain: Recording, number: int = 0) -> Effect:
    """An effect of that cause for the rig, of a size in the middle of what there is. plain: the rig without it."""
    entry, chance = ALL[cause], luck(rig.seed, 13, number)
    form = str(chance.choice(entry.forms))
    if cause == "clock_step" and not rig.camera.stamped:
        form = "frames"
    if cause == "stale_frame_buffer" and form == "with_stamp" and not rig.camera.stamped:
        form = "content"
    onset = 0.0
    if chance.random() < entry.onset or form == "from_onset":
        onset = rig.duration_s * float(chance.uniform(0.25, 0.7))
    extras = entry.extras(chance, rig)
    sign = int(chance.choice([-1, 1])) if entry.signed else 1
    if cause == "accelerometer_clipping":
        extras["peak_m_s2"] = (
            float(np.max(np.abs(plain.acceleration))) if plain.acceleration is not None else 1.0
        )
    if cause == "lens_distortion":
        extras["edge_px"] = edge_px = float(np.max(np.abs(plain.px - rig.camera.offset_px)))
        if form == "off_centre":
            extras["centre_px"] = float(chance.uniform(-0.4, 0.4)) * edge_px
    if cause == "drive_saturation":
        extras["peak"] = _peak(form, plain, sign)
    size = log_uniform(chance, entry.low, entry.high)
    if entry.fitted:
        size = float(np.sqrt(entry.low * entry.high))
    if cause == "stale_frame_buffer":
        size = float(chance.integers(1, 4))
    return Effect(cause, form, size, sign, onset, int(chance.integers(1, 2**31)), extras)


def _peak(form: str, plain: Recording, sign: int) -> float:
    """Largest speed that is asked for, or acceleration of the joint; of one direction where the limit is."""
    asked = plain.motion.asked
    course = asked if form.startswith("velocity") else np.diff(plain.motion.link_rad_s) / STEP_S
    return float(np.max(sign * course if form.endswith("by_direction") else np.abs(course)))


def resized(effect: Effect, size: float) -> Effect:
    """The same within the bounds of its cause."""
    entry = ALL[effect.cause]
    return replace(effect, size=float(np.clip(size, entry.low, entry.high)))
