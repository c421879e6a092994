"""The baseline with the stated modes, where the fitted one has left them."""

from dataclasses import replace

import numpy as np
import pytest
from msgspec.structs import replace as changed

from stillarm.common.files.model import Mode
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import Fit, make_data
from stillarm.diagnosis.search.stated_baseline import stated_baseline
from tests.fixtures.synthetic import MODEL, fitted, measured

SECONDS = 10.0
SPLIT = interleaved(SECONDS)
HZ, DAMPING = "modes.0.frequency_hz", "modes.0.damping_ratio"
SCALE, DELAY = "camera.scale_px_per_m", "timing.capture_delay_s"


@pytest.fixture(scope="module")
def rubbing() -> Fit:
    """The baseline of an arm that dry friction stops soon, where a fit had ended with a heavily damped mode."""
    baseline = fitted(measured(SECONDS, 5, {"arm.coulomb_m_s2": 1.0}))
    return moved(baseline, {HZ: 1.6 * baseline.world.space[HZ].start, DAMPING: 0.4})


def moved(baseline: Fit, values: dict[str, float]) -> Fit:
    """The baseline with other values, everything else as it is."""
    world = baseline.world
    start = world.space.with_values(baseline.vector, values)
    return fit(make_data(world, SPLIT), start, baseline.free, iterations=0)


@pytest.mark.parametrize(
    ("of_hz", "damping", "far"), [(1.1, 0.04, False), (1.2, 0.04, True), (0.8, 0.04, True), (1.0, 0.3, True)]
)
def test_a_baseline_has_left_the_stated_modes_where_no_model_is_as_wrong(
    rubbing: Fit, of_hz: float, damping: float, far: bool
) -> None:
    stated_hz = rubbing.world.space[HZ].start
    one = moved(rubbing, {HZ: of_hz * stated_hz, DAMPING: damping})
    found = stated_baseline(one, SPLIT)
    assert (found is not None) == far
    if found is not None:
        assert found.value(HZ) == stated_hz and HZ not in found.free and "camera.offset_px" in found.free


@pytest.mark.parametrize(
    ("scale", "later_swings", "far"),
    [(0.6, 0.2, False), (-0.6, 0.0, True), (1.0, -0.3, True), (1.0, 0.3, True)],
)
def test_a_baseline_has_left_the_stated_images_where_it_turns_them_over_or_dates_them_by_another_swing(
    rubbing: Fit, scale: float, later_swings: float, far: bool
) -> None:
    space = rubbing.world.space
    hz, stated_px, stated_s = (space[name].start for name in (HZ, SCALE, DELAY))
    values = {HZ: hz, DAMPING: 0.01, SCALE: scale * stated_px, DELAY: stated_s + later_swings / hz}
    found = stated_baseline(moved(rubbing, values), SPLIT)
    assert (found is not None) == far
    if found is not None:
        assert found.value(SCALE) == stated_px and found.value(DELAY) == stated_s and HZ in found.free


@pytest.mark.slow
def test_a_tilt_is_found_beside_images_as_stated() -> None:
    """A camera that turns with the joint so that the images show next to nothing of the bend: they are fitted with a
    twelfth of the scale, and half a swing early."""
    baseline = fitted(measured(SECONDS, 5, {"camera.rotation_px_per_rad": -1500.0}))
    stated_px, stated_s = (baseline.world.space[name].start for name in (SCALE, DELAY))
    assert abs(baseline.value(SCALE)) < 0.2 * stated_px and abs(baseline.value(DELAY) - stated_s) > 0.1
    found = explain(baseline, SPLIT, only=("camera_tilt_coupling", "lens_distortion", "stale_frame_buffer"))
    assert [one.cause for one in found.findings] == ["camera_tilt_coupling"]
    assert found.final.value(SCALE) == pytest.approx(stated_px, rel=0.05)
    assert found.final.value("camera.rotation_px_per_rad") == pytest.approx(-1500.0, rel=0.05)


@pytest.mark.slow
def test_friction_is_found_beside_the_stated_modes(rubbing: Fit) -> None:
    found = explain(rubbing, SPLIT, only=("coulomb_damping", "quadratic_damping", "drive_lag"))
    assert [one.cause for one in found.findings] == ["coulomb_damping"]
    assert found.final.value("arm.coulomb_m_s2") == pytest.approx(1.0, rel=0.05)


@pytest.mark.slow
def test_a_hum_is_found_that_an_undamped_mode_had_taken_over() -> None:
    """Beside that mode as stated, and no other: the first one's frequency is fitted."""
    modes = [Mode(frequency_hz=2.5), Mode(frequency_hz=49.97, damping_ratio=0.003, participation=-0.1)]
    two = changed(MODEL, arm=changed(MODEL.arm, modes=modes))
    plain = measured(SECONDS, 5, {HZ: 2.52}, model=two)
    hum = 8.0 * np.sin(2.0 * np.pi * 50.02 * 0.001 * np.arange(plain.cycles))
    with_hum = replace(plain, acceleration=plain.acceleration + hum)
    baseline = fitted(with_hum, model=two)
    assert baseline.value("modes.1.frequency_hz") == pytest.approx(50.02, abs=0.01)
    stated = stated_baseline(baseline, SPLIT)
    assert stated is not None and HZ in stated.free
    assert stated.value("modes.1.frequency_hz") == 49.97
    found = explain(baseline, SPLIT, only=("mains_hum", "drive_lag"))
    assert [one.cause for one in found.findings] == ["mains_hum"]
    assert found.findings[0].values["amplitude_m_s2"][0] == pytest.approx(8.0, rel=0.1)  # half a beat
    assert found.final.value("modes.1.damping_ratio") > 0.001
