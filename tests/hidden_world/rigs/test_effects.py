"""Each effect, in each of its forms, changes the channels that it should, and no other."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.hidden_world.rigs.arm_effects import CHANGES
from tests.hidden_world.rigs.catalogue import ALL, CAUSES, UNLISTED
from tests.hidden_world.rigs.departure import departures
from tests.hidden_world.rigs.draw import draw_effect, draw_rig
from tests.hidden_world.rigs.moves import Move
from tests.hidden_world.rigs.recording import Recording, record
from tests.hidden_world.rigs.rig import Accelerometer, Arrival, Effect, Encoder, Nuisance, Rig
from tests.hidden_world.rigs.sensors import GRAVITY_M_S2, acceleration

pytestmark = pytest.mark.slow

ARM = {"acceleration", "displacement"}
JOINT = ARM | {"joint_position", "joint_velocity"}
CHANGED = {
    "accelerometer": {"acceleration"},
    "camera": {"displacement"},
    "camera_clock_skew": {"displacement", "image_timing"},
    "frame_drops": {"lost"},
    "delay_bursts": {"image_timing"},
    "delay_drift": {"image_timing"},
}
CAMERA = (
    "tracking_drift",
    "lens_distortion",
    "camera_tilt_coupling",
    "image_scale_drift",
    "torsion_in_image",
    "loose_camera_mount",
)
DRIVE = ("drive_", "joint_", "gear_")
FORMS = [(cause, form) for cause, entry in ALL.items() for form in entry.forms]
MOVES = [
    Move("trapezoid", 0.8, 0.25, ramp_s=0.2, hold_s=0.5),
    Move("step", 2.6, -0.3, ramp_s=0.02, hold_s=0.5),
    Move("doublet", 4.3, 0.2, hold_s=0.15),
    Move("impact", 5.6, 0.1, ramp_s=0.006),
    Move("trapezoid", 6.5, 0.35, ramp_s=0.05, hold_s=0.3),
]


@cache
def rig() -> Rig:
    """Everything is measured; nothing is lost in a quantum; no nuisance."""
    drawn = next(r for r in map(draw_rig, range(100)) if len(r.modes) == 1 and not r.camera.triggered)
    return replace(
        drawn,
        duration_s=8.0,
        modes=(replace(drawn.modes[0], frequency_hz=3.0, damping_ratio=0.01),),
        length_m=1.5,
        drive=replace(drawn.drive, bandwidth_hz=20.0, max_velocity_rad_s=1.0, max_acceleration_rad_s2=200.0),
        encoder=Encoder(1e-5, 1e-3, 0.0, False),
        accelerometer=Accelerometer(1.0, 0.1, 0.0, 200.0, 0.0),
        camera=replace(drawn.camera, frame_rate_hz=60.0, exposure_s=0.01, stamped=True, stamp_quantum_s=1e-6),
        arrival=Arrival(0.08, 0.003, 0.4, 5.0, False, "latest", 1e-3),
        nuisance=Nuisance(),
        swinging_m=0.0,
        fastest_rad_s=0.35,
    )


@cache
def plain() -> Recording:
    return record(rig(), MOVES, noise=False)


def hidden(cause: str, form: str) -> Effect:
    drawn = draw_effect(cause, rig(), plain())
    extras = drawn.extras | {"centre_px": 20.0} if form == "off_centre" else drawn.extras
    peak = {"velocity": 0.35, "acceleration": 30.0}.get(form.split("_", maxsplit=1)[0], 1.0)
    extras = extras | ({"peak": peak} if cause == "drive_saturation" else {})
    onset = 3.0 if ALL[cause].onset == 1.0 or form == "from_onset" else 0.0
    return replace(drawn, form=form, onset_s=onset, sign=1, extras=extras)


def expected(cause: str, form: str) -> set[str]:
    if cause == "stale_frame_buffer":
        if form == "queue":
            return {"image_timing"}
        return {"displacement", "stamp"} if form == "with_stamp" else {"displacement"}
    if cause == "clock_step":
        return {"stamp"} if form == "camera" else {"image_timing"}
    if cause in CAMERA:
        return CHANGED["camera"]
    if cause.startswith("accelerometer") or cause in ("gravity_leakage", "mains_hum", "impulse_noise"):
        return CHANGED["accelerometer"]
    return CHANGED.get(cause, JOINT if cause.startswith(DRIVE) else ARM)


@pytest.mark.parametrize(("cause", "form"), FORMS)
def test_it_changes_what_it_should_and_nothing_else(cause: str, form: str) -> None:
    effect = hidden(cause, form)
    motion = None if cause in CHANGES else plain().motion
    changed = record(rig(), MOVES, (effect,), False, motion)
    seen = departures(changed, plain())
    nothing = {"stamp": 1e-4}  # another exposure has another jitter
    if cause == "frame_drops":
        nothing["image_timing"] = 1.001e-3  # a cycle's rounding
    moved = {name for name, d in seen.items() if d.rms > nothing.get(name, 1e-9)}
    assert moved == expected(cause, form)
    assert all(np.isfinite(d.rms) for d in seen.values())


def test_all_of_the_contract_and_more_are_there() -> None:
    assert len(CAUSES) == 29 and len(UNLISTED) >= 8 and not set(CAUSES) & set(UNLISTED)


@pytest.mark.parametrize("cause", [c for c, entry in ALL.items() if entry.fitted])
def test_a_larger_size_changes_more(cause: str) -> None:
    entry = ALL[cause]
    effect = hidden(cause, entry.forms[0])
    sizes = []
    for size in (effect.size, min(2.0 * effect.size, entry.high)):
        motion = None if cause in CHANGES else plain().motion
        changed = record(rig(), MOVES, (replace(effect, size=size),), False, motion)
        sizes.append(max(d.rms for d in departures(changed, plain()).values() if d.rms > 1e-9))
    assert sizes[1] > 1.2 * sizes[0]


def test_what_begins_inside_leaves_what_was_before() -> None:
    effect = replace(hidden("joint_friction", "coulomb"), onset_s=4.0)
    changed = record(rig(), MOVES, (effect,), False)
    apart = np.abs(changed.acceleration - plain().acceleration)
    assert np.max(apart[:4000]) == 0.0 and np.max(apart[4000:]) > 0.01


def test_gravity_leaks_by_the_sine_of_the_angle() -> None:
    effect = Effect("gravity_leakage", "sine", GRAVITY_M_S2)
    motion = plain().motion
    leaked = acceleration(rig(), motion, (effect,), False) - acceleration(rig(), motion, (), False)
    assert leaked == pytest.approx(GRAVITY_M_S2 * np.sin(motion.link_rad[::10][:8000]), abs=1e-12)


def test_frames_are_lost_at_the_rate_that_is_told() -> None:
    effect = Effect("frame_drops", "single", 0.2, seed=3)
    longer = replace(rig(), duration_s=60.0)
    kept = len(record(longer, [], (effect,), False).images.index) / len(
        record(longer, [], (), False).images.index
    )
    assert kept == pytest.approx(0.8, abs=0.03)
