"""Images against an evaluation of their own: the scene's waves, summed at the exact places, and averaged."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import SimulatedScene
from stillarm.common.files.model import Camera
from stillarm.simulation.camera.image_motion import Interpolate, mean_displacement_px, sub_exposures
from stillarm.simulation.camera.pose_history import PoseHistory, PoseNotYet
from stillarm.simulation.camera.renderer import Renderer
from stillarm.simulation.camera.scene import make_scene

Motion = Callable[[np.ndarray], np.ndarray]
SMALL = SimulatedScene(width_px=160, height_px=120, noise_grey_levels=0.0)


def _interpolate(position: Motion, angle: Motion = np.zeros_like) -> Interpolate:
    return lambda times: (position(times), angle(times))


def _shifted(
    height: int, width: int, seed: int, displacement_px: np.ndarray, smear_px: float = 0.0
) -> np.ndarray:
    """The scene moved by a displacement for each row, and smeared evenly over `smear_px` about it.

    Evaluated from its Fourier series, and so exact at any fraction: a smear takes a wave down by its sinc.
    """
    scene = make_scene(width, height, seed)
    waves = np.fft.rfft(scene.texture[:, : scene.period].astype(np.float64), axis=1)
    frequency = np.fft.rfftfreq(scene.period)[None, :]
    waves *= np.exp(-2j * np.pi * frequency * displacement_px[:, None]) * np.sinc(frequency * smear_px)
    return np.asarray(np.fft.irfft(waves, n=scene.period, axis=1)[:, :width])


def _error_px(image: np.ndarray, exact: np.ndarray) -> float:
    """Shift of the image against the exact one, by least squares, px."""
    slope = np.gradient(exact, axis=1)[:, 2:-2]
    return float(np.sum((image.astype(float) - exact)[:, 2:-2] * slope) / np.sum(slope * slope))


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(displacement=st.floats(-4000.0, 4000.0))
def test_a_scene_at_rest_lies_where_it_should_to_a_hundredth_of_a_pixel(displacement: float) -> None:
    renderer = _renderer(Camera())
    image = renderer.render(_interpolate(lambda t: np.full_like(t, -displacement / 800.0)), 0.0, 0)
    exact = _shifted(120, 160, 5, np.full(120, displacement))
    assert abs(_error_px(image, exact)) < 0.003
    assert np.abs(image - exact).max() < 0.75  # half a grey level is the rounding


@pytest.mark.parametrize("speed_px_s", [0.0, 80.0, -960.0, 3000.0])
def test_the_image_integrates_over_the_exposure(speed_px_s: float) -> None:
    motion = _interpolate(lambda t: -(3.3 + speed_px_s * t) / 800.0)
    image = _renderer(Camera()).render(motion, 0.2, 0)
    exact = _shifted(120, 160, 5, np.full(120, 3.3 + speed_px_s * 0.2075), speed_px_s * 0.015)
    assert np.abs(image - exact).max() < 0.8
    assert abs(_error_px(image, exact)) < 0.01


@pytest.mark.parametrize("speed_px_s", [80.0, 960.0])
def test_a_rolling_shutter_exposes_each_row_in_its_own_window(speed_px_s: float) -> None:
    camera = Camera(shutter="rolling", readout_s=0.01, exposure_s=0.005)
    motion = _interpolate(lambda t: -speed_px_s * t / 800.0)
    image = _renderer(camera).render(motion, 1.0, 0)
    row_start = 1.0 + np.arange(120) / 120 * 0.01
    exact = _shifted(120, 160, 5, speed_px_s * (row_start + 0.0025), speed_px_s * 0.005)
    tolerance = 0.01 if speed_px_s < 100.0 else 0.15  # in fast moves four rows are drawn as one
    for part in (slice(0, 40), slice(40, 80), slice(80, 120)):
        assert abs(_error_px(image[part], exact[part])) < tolerance
    assert abs(_error_px(image, exact)) < 0.01
    at_once = _renderer(Camera(exposure_s=0.005)).render(motion, 1.0, 0)
    assert abs(_error_px(at_once[80:], exact[80:])) > 0.3  # a global shutter would not go unnoticed


def test_the_contracts_equation_holds_with_both_signs_and_the_rotation() -> None:
    camera = Camera(scale_px_per_m=-500.0, rotation_px_per_rad=70.0)
    motion = _interpolate(lambda t: np.full_like(t, 0.02), lambda t: np.full_like(t, 0.1))
    image = _renderer(camera).render(motion, 0.0, 0)
    exact = _shifted(120, 160, 5, np.full(120, 500.0 * 0.02 - 70.0 * 0.1))
    assert abs(_error_px(image, exact)) < 0.003


@pytest.mark.slow
def test_a_vibration_is_centred_on_the_middle_of_the_exposure() -> None:
    camera, w = Camera(), 2.0 * np.pi * 2.6
    renderer = _renderer(camera)

    def motion(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return -5.0 * np.sin(w * times) / 800.0, np.zeros_like(times)

    for start in np.arange(12) * 0.031:
        image = renderer.render(motion, float(start), 0)
        attenuated = 5.0 * np.sin(w * (start + 0.0075)) * np.sinc(2.6 * 0.015)
        assert abs(_error_px(image, _shifted(120, 160, 5, np.full(120, attenuated)))) < 0.01
        assert mean_displacement_px(camera, motion, float(start)) == pytest.approx(attenuated, abs=1e-6)


def test_noise_has_its_level_differs_from_frame_to_frame_and_repeats_with_the_seed() -> None:
    scene = SimulatedScene(width_px=160, height_px=120, noise_grey_levels=2.0)
    still = _interpolate(np.zeros_like)
    clean = _renderer(Camera()).render(still, 0.0, 0).astype(float)
    noisy, other = (Renderer(Camera(), scene, 5), Renderer(Camera(), scene, 5))
    first, second = noisy.render(still, 0.0, 1), noisy.render(still, 0.0, 2)
    assert (first - clean).std() == pytest.approx(2.0, rel=0.05)
    difference = (first.astype(float) - second).ravel()
    assert difference.std() == pytest.approx(2.0 * np.sqrt(2.0), rel=0.05)
    np.testing.assert_array_equal(other.render(still, 0.0, 2), second)  # whatever was rendered before
    np.testing.assert_array_equal(noisy.render(still, 0.0, 1), first)
    assert first.dtype == np.uint8
    assert first.shape == (120, 160)


def test_phase_correlation_sees_the_scene_move_the_right_way() -> None:
    renderer = Renderer(Camera(), SimulatedScene(width_px=320, height_px=240), 2)
    rest = renderer.render(_interpolate(np.zeros_like), 0.0, 0).astype(np.float32)
    moved = renderer.render(_interpolate(lambda t: np.full_like(t, -4.0 / 800.0)), 0.0, 1).astype(np.float32)
    window = cv2.createHanningWindow((320, 240), cv2.CV_32F)
    (dx, dy), _ = cv2.phaseCorrelate(rest, moved, window)
    assert dx == pytest.approx(4.0, abs=0.3)
    assert dy == pytest.approx(0.0, abs=0.3)


def test_sub_exposures_follow_the_span() -> None:
    assert sub_exposures(0.0) == 3
    assert 15 <= sub_exposures(14.0) <= 17
    assert sub_exposures(1e6) == 64
    assert [sub_exposures(s) for s in range(40)] == sorted(sub_exposures(s) for s in range(40))


def test_an_instantaneous_exposure_is_a_picture_of_its_start() -> None:
    image = _renderer(Camera(exposure_s=0.0)).render(_interpolate(lambda t: -1000.0 * t / 800.0), 0.1234, 0)
    assert abs(_error_px(image, _shifted(120, 160, 5, np.full(120, 123.4)))) < 0.003


def test_a_pose_that_is_not_there_yet_is_passed_on() -> None:
    with pytest.raises(PoseNotYet):
        _renderer(Camera()).render(PoseHistory(None).interpolate, 0.0, 0)


_RENDERERS: dict[Camera, Renderer] = {}


def _renderer(camera: Camera) -> Renderer:
    if camera not in _RENDERERS:
        _RENDERERS[camera] = Renderer(camera, SMALL, 5)
    return _RENDERERS[camera]
