"""An encoder or an image that is finer than the simulation, or the tracker, is right."""

from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.noise import LEAST, is_fine_encoder, is_fine_image
from stillarm.diagnosis.physics.measured_joint import answer_to_path, noise_at_tip, tip_moved, within_reach
from stillarm.diagnosis.physics.world import World
from tests.fixtures import synthetic

Array = NDArray[np.float64]

_STEP_S = 0.001
_MODE = np.array([[2.6, 0.01, 1.14]])


def _swing() -> Array:
    time = np.arange(4000) * _STEP_S
    moved: Array = 0.1 * np.sin(2.0 * np.pi * 0.4 * time)
    return moved


def _tip_moved(off: Array, modes: Array, length: float) -> Array:
    return tip_moved(
        off, modes, length, lambda hz, damping: answer_to_path(length * off, hz, damping, _STEP_S)
    )


@pytest.mark.parametrize(
    ("step", "noise", "fine"),
    [
        (0.0, 0.0, True),
        (2.0 * np.pi / 2**20, 0.0, True),
        (2.0 * np.pi / 2**16, 0.0, False),
        (0.0, 8e-5, False),
        (0.0, 1e-5, True),
    ],
)
def test_an_encoder_is_fine_by_its_steps_and_its_noise(step: float, noise: float, fine: bool) -> None:
    """Steps of a 16-bit encoder, and noise of most of the least level, are not."""
    position = _swing() + np.random.default_rng(1).normal(0.0, noise, 4000)
    position = np.rint(position / step) * step if step else position
    position[100:110] = np.nan
    assert is_fine_encoder(position) is fine


def test_no_encoder_is_not_fine() -> None:
    """Nothing measured, nothing to go by."""
    assert not is_fine_encoder(np.full(4000, np.nan))


@pytest.mark.parametrize(("noise", "fine"), [(0.002, True), (0.03, False)])
def test_an_image_is_fine_by_its_noise(noise: float, fine: bool) -> None:
    """Whatever it shows of an arm that rings."""
    time = np.arange(1300) / 65.0
    ring = 5.0 * np.cos(2.0 * np.pi * 2.6 * time)
    assert is_fine_image(ring + np.random.default_rng(2).normal(0.0, noise, len(time))) is fine


def test_an_image_that_is_shaken_quickly_is_not_called_fine() -> None:
    """Its noise cannot be told from its motion."""
    time = np.arange(1300) / 65.0
    assert not is_fine_image(0.1 * np.cos(2.0 * np.pi * 23.0 * time))


def test_no_more_than_a_simulation_may_be_off() -> None:
    """What the joint shows beyond that is for the causes; what was not measured lies between what was."""
    measured = np.array([0.0, np.nan, 2e-5, 1.0, -1.0])
    most = LEAST["joint_position"]
    assert within_reach(measured, np.zeros(5)) == pytest.approx([0.0, 1e-5, 2e-5, most, -most])


@pytest.mark.slow
def test_the_arm_rings_with_the_joint() -> None:
    """The tip's path is that of the equation of motion, solved by another method."""
    time = np.arange(3000) * _STEP_S
    begin, lasts, size = 0.3, 0.2, 5e-5  # a raised cosine, so that its acceleration is known

    def phase(t: Any) -> Any:
        return np.pi * np.clip((t - begin) / lasts, 0.0, 1.0)

    off = 0.5 * size * (1.0 - np.cos(phase(time)))
    hz, damping, participation = _MODE[0]
    w, length = 2.0 * np.pi * hz, 2.0

    def motion(t: float, state: Array) -> list[float]:
        inside = begin < t < begin + lasts
        push = 0.5 * size * (np.pi / lasts) ** 2 * np.cos(float(phase(t))) if inside else 0.0
        return [
            state[1],
            -2.0 * damping * w * state[1] - w * w * state[0] - participation * length * push,
        ]

    solved = solve_ivp(motion, (0.0, 3.0), [0.0, 0.0], t_eval=time, rtol=1e-8, atol=1e-12, max_step=1e-3)
    truth = length * off + solved.y[0]
    found = _tip_moved(off, _MODE, length)
    assert np.max(np.abs(found - truth)) < 0.01 * np.max(np.abs(truth))


@pytest.mark.parametrize(("hz", "damping"), [(10.0, 0.006), (2.0, 0.01)])
def test_an_encoders_noise_rings_the_tip_as_is_foretold(hz: float, damping: float) -> None:
    modes, length, noise = np.array([[hz, damping, 1.5]]), 0.9, 3e-5
    off = np.random.default_rng(4).normal(0.0, noise, 200_000)
    moved = _tip_moved(off, modes, length)[20_000:]
    assert noise_at_tip(noise, modes, length, _STEP_S) == pytest.approx(float(np.std(moved)), rel=0.15)


@pytest.mark.parametrize("scale", [800.0, -800.0])
@pytest.mark.parametrize(("noise", "told"), [(1e-6, True), (3e-5, False)])
def test_an_encoder_that_would_ring_the_image_does_not_correct_it(
    scale: float, noise: float, told: bool
) -> None:
    model = msgspec.structs.replace(
        synthetic.MODEL, camera=msgspec.structs.replace(synthetic.MODEL.camera, scale_px_per_m=scale)
    )
    bare = synthetic.empty(6.0, model)
    true = World(bare, model)
    position = true.predict(true.space.vector()).channels["joint_position"]
    data = replace(bare, position=position + np.random.default_rng(2).normal(0.0, noise, bare.cycles))
    shown = World(data, model)
    moved = replace(data, position=data.position + 5e-5 * (np.arange(data.cycles) > 3000))
    elsewhere = World(moved, model)
    vector = shown.space.vector()
    there, here = (one.predict(vector).channels["displacement"] for one in (elsewhere, shown))
    assert bool(np.abs(there - here).max() > 0.01) is told


def _late_commands(position_noise: float) -> Measured:
    """A recording in which every tenth of a second a command is carried out some cycles late."""
    bare = synthetic.empty(20.0)
    given = 0.1 * np.sin(2.0 * np.pi * 0.7 * bare.cycle_s * np.arange(bare.cycles))
    random, held = np.random.default_rng(3), given.copy()
    for at in range(100, len(held) - 20, 100):
        held[at : at + int(random.integers(1, 8))] = held[at - 1]
    true = World(replace(bare, command=held), synthetic.MODEL)
    shown = true.predict(true.space.vector()).channels
    return replace(
        bare, command=given, reference=given,
        acceleration=shown["acceleration"] + random.normal(0.0, 0.3, bare.cycles),
        position=shown["joint_position"] + random.normal(0.0, position_noise, bare.cycles),
        velocity=shown["joint_velocity"],
        frames=replace(bare.frames, displacement_px=shown["displacement"]),
    )  # fmt: skip


@pytest.mark.parametrize(("position_noise", "told"), [(1e-6, True), (1e-4, False)])
def test_late_commands_do_not_show_in_the_image(position_noise: float, told: bool) -> None:
    """Where the encoder tells of them, which is under what the joint's simulation is held to; a coarse one does not."""
    data = _late_commands(position_noise)
    fitted = synthetic.fitted(data)
    joint = fitted.residuals["joint_position"]
    assert float(np.std(joint)) < 1.5 * LEAST["joint_position"]
    left = float(np.std(fitted.residuals["displacement"]))
    assert (left < LEAST["displacement"]) is told


def test_a_joint_within_reach_is_no_discovery_and_one_beyond_is() -> None:
    """A fine encoder's many samples say nothing of what a simulated drive may be off; they do of more."""
    world = World(_late_commands(1e-6), synthetic.MODEL)
    vector = world.space.vector()
    for name, size in (("drive.deadband_rad_s", 0.03), ("drive.dead_time_s", 0.02)):
        moved = vector.copy()
        moved[world.space.place[name]] = size
        for one, found in ((vector, False), (moved, True)):
            left = world.channels["joint_position"] - world.predict(one).channels["joint_position"]
            assert bool(np.max(np.abs(left)) > LEAST["joint_position"]) is found, name


def _locked(amplitude_px: float) -> Measured:
    """A ring-down as a tracker shows it that strays with the place in the pixel; noise of 0.002 px."""
    bare = synthetic.empty(20.0)
    world = World(bare, synthetic.MODEL)
    vector = world.space.vector()
    vector[world.space.place["jump.0.0.q"]] = 0.006
    shown = world.predict(vector).channels
    place = shown["displacement"]
    strayed = place + amplitude_px * np.sin(2.0 * np.pi * place)
    noisy = strayed + np.random.default_rng(5).normal(0.0, 0.002, len(place))
    return replace(
        bare, acceleration=shown["acceleration"], position=shown["joint_position"],
        velocity=shown["joint_velocity"], frames=replace(bare.frames, displacement_px=noisy),
    )  # fmt: skip


def test_a_trackers_error_with_the_place_in_the_pixel_is_part_of_the_baseline() -> None:
    """As far as good trackers err; it is known then, and leaves nothing."""
    fitted = synthetic.fitted(_locked(0.008))
    assert fitted.value("camera.locking_sin_px") == pytest.approx(0.008, abs=0.0005)
    assert float(np.std(fitted.residuals["displacement"])) < 0.003


def test_an_error_beyond_that_stays_to_be_found() -> None:
    """A lens or a tracker that strays by a twentieth of a pixel is a discovery."""
    fitted = synthetic.fitted(_locked(0.05))
    assert float(np.std(fitted.residuals["displacement"])) > 0.01


def test_a_coarse_image_has_no_such_part() -> None:
    """Its noise hides what a good tracker strays, so that whatever shows is something else."""
    data = synthetic.measured(20.0, 1)
    assert "camera.locking_sin_px" not in World(data, synthetic.MODEL).baseline_names()
