"""Every cause: looked for by trials that do something, told by the contract's parameters, written as an effect."""

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from stillarm.common.causes import CAUSES as CATALOGUE
from stillarm.common.files.model import Mode, load_model
from stillarm.common.files.scenario import Scenario, Strike
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.decision.explain import explain
from stillarm.diagnosis.fitting.fitted import Fit, carried_over
from stillarm.diagnosis.fitting.peaks import residual_peaks
from stillarm.diagnosis.forms.cause import Context
from stillarm.diagnosis.forms.causes import CAUSES
from stillarm.diagnosis.physics.quantities import HIGHER, SKEW, SKEW_BEGIN
from stillarm.diagnosis.report.extended_model import effect_of, model_text
from stillarm.diagnosis.search.candidates import Candidate
from stillarm.diagnosis.search.screen import variant
from stillarm.simulation.virtual_time.virtual_time import VirtualRun, simulate
from tests.fixtures.simulated import MODEL as RIG_MODEL
from tests.fixtures.simulated import SIZES
from tests.fixtures.synthetic import MODEL, NOISE, fitted, measured

LAWS = {"impulse_noise", "frame_drops", "delay_bursts"}
SPLIT = interleaved(6.0)
QUANTITIES = {
    "coulomb_damping": {"arm.coulomb_m_s2": 0.08},
    "quadratic_damping": {"arm.quadratic_per_m": 6.0},
    "cubic_stiffness": {"arm.cubic_per_m2": 20.0},
    "stiffness_drift": {"arm.frequency_rate_per_s": 0.004},
    "drive_dead_time": {"drive.dead_time_s": 0.02},
    "drive_lag": {"drive.bandwidth_hz": 6.0},
    "joint_friction": {"drive.velocity_loss_rad_s": 0.01},
    "accelerometer_bias_drift": {"accelerometer.rate_m_s3": 0.1},
    "accelerometer_sensitivity_drift": {"accelerometer.rate_per_s": 0.03},
    "accelerometer_lag": {"accelerometer.delay_s": 0.01},
    "gravity_leakage": {"accelerometer.gravity_m_s2_per_rad": 4.0},
    "tracking_drift": {"camera.rate_px_per_s": 0.5},
    "lens_distortion": {"camera.lens_per_px2": 1e-6},
    "camera_tilt_coupling": {"camera.rotation_px_per_rad": 150.0},
    "camera_clock_skew": {"timing.skew_ppm": 800.0},
}
"""Causes whose quantities have smooth derivatives, at a size that six seconds show."""


@pytest.fixture(scope="module")
def plain() -> Fit:
    """The baseline on data with nothing wrong."""
    return fitted(measured(6.0, 1), split=SPLIT)


def test_the_catalogue_is_searched_whole() -> None:
    assert set(CAUSES) | LAWS == set(CATALOGUE)


@pytest.mark.slow
@pytest.mark.parametrize("cause", sorted(QUANTITIES))
def test_a_fit_finds_the_parameter_within_its_deviation(cause: str) -> None:
    data = measured(6.0, 2, QUANTITIES[cause])
    found = fitted(data, *CAUSES[cause].free(fitted(data).world))
    for name, true in QUANTITIES[cause].items():
        assert found.value(name) == pytest.approx(true, abs=5.0 * found.std[name])
        assert found.value(name) == pytest.approx(true, rel=0.15)
        assert found.std[name] < 0.05 * abs(true)


@pytest.mark.slow
def test_a_camera_clock_that_goes_wrong_on_the_way_is_found_with_its_onset() -> None:
    data = measured(12.0, 2, {SKEW: 600.0, SKEW_BEGIN: 6.0})
    found = explain(fitted(data), interleaved(12.0), only=["camera_clock_skew", "delay_drift", "clock_step"])
    assert [(one.cause, one.form) for one in found.findings] == [("camera_clock_skew", "from an onset")]
    assert found.final.value(SKEW) == pytest.approx(600.0, rel=0.1)
    assert found.final.value(SKEW_BEGIN) == pytest.approx(6.0, abs=0.5)


@pytest.mark.blind(each_run=2, seed=4)
@pytest.mark.parametrize("share", [0.0, 1.0])
@pytest.mark.parametrize(
    ("cause", "values"),
    [
        ("payload_change", {"arm.onset_s": 5.0, "arm.frequency_ratio": 0.997}),
        ("stiffness_drift", {"arm.frequency_rate_per_s": -6e-4}),
    ],
)
def test_a_change_of_frequency_is_found_whatever_share_of_it_the_second_mode_takes(
    cause: str, values: dict[str, float], share: float
) -> None:
    modes = [*MODEL.arm.modes, Mode(frequency_hz=12.0, damping_ratio=0.004, participation=-0.3)]
    model = msgspec.structs.replace(MODEL, arm=msgspec.structs.replace(MODEL.arm, modes=modes))
    data = measured(12.0, 4, values | {HIGHER: share}, model=model)
    found = explain(fitted(data, model=model), interleaved(12.0), only=[cause, "second_bending_mode"])
    assert [one.cause for one in found.findings] == [cause]
    assert found.final.value(HIGHER) == pytest.approx(share, abs=4.0 * found.final.std[HIGHER])
    assert found.final.std[HIGHER] < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("cause", sorted(CAUSES))
def test_its_trials_move_some_channel_and_its_parameters_are_the_catalogues(cause: str, plain: Fit) -> None:
    one = CAUSES[cause]
    assert one.needs(plain.world)
    trials = one.trials(Context(plain, residual_peaks(plain) | {"acceleration": (7.0, 50.0)}))
    assert trials
    effective = 0
    for trial in trials[:6]:
        world = variant(plain.world, dict(trial.options))
        start = carried_over(plain, world)
        base = world.predict(start).channels
        moved = start.copy()
        for name, value in {**trial.shape, **trial.columns[0]}.items():
            moved[world.space.place[name]] = value
        shown = world.predict(world.space.clipped(moved)).channels
        effective += any(np.max(np.abs(np.nan_to_num(shown[name] - base[name]))) > 0.0 for name in base)
        names = one.free(world)
        assert all(name in world.space.place for name in names)
    assert effective
    world = variant(plain.world, dict(trials[0].options))
    start = carried_over(plain, world)
    nothing = np.zeros(len(SPLIT.held))
    other = Fit(
        world,
        start,
        one.free(world),
        {},
        plain.sigma,
        {},
        plain.residuals,
        world.predict(start),
        0.0,
        nothing,
    )
    required = {p.name for p in CATALOGUE[cause].parameters if p.default is None}
    told = set(one.parameters_of(other))
    assert required <= told <= {p.name for p in CATALOGUE[cause].parameters}


def _extended(cause: str) -> dict[str, object]:
    values = {name: (value, 0.0) for name, value in SIZES[cause].items() if isinstance(value, float | int)}
    one = Candidate(cause, _NOBODY, 0.0, 0.0, values, law=_LAW)  # type: ignore[arg-type]
    return dict(effect_of(one, _NOBODY))  # type: ignore[arg-type]


class _Nobody:
    """A fit of which nothing but a phase and the encoder's side is asked."""

    def value(self, name: str) -> float:
        """Any quantity."""
        return 0.3

    @property
    def world(self) -> "_Nobody":
        """Whose encoder is the joint's."""
        return self

    behind_encoder = False


_NOBODY, _LAW = _Nobody(), object()


@pytest.mark.slow
def test_extended_models_load_and_run(tmp_path: Path) -> None:
    """Each cause as an effect in a file that a user would have, in the simulation that he would run."""
    from stillarm.common.files.configuration import load_configuration
    from stillarm.simulation.virtual_time.simulated_recording import default_simulation_configuration

    configuration = load_configuration(default_simulation_configuration())
    scenario = Scenario(duration_s=0.2, strikes=[Strike(0.05, 0.02)])

    class Nowhere:
        """Takes everything."""

        def write(self, topic_name: str, message: msgspec.Struct) -> None:
            """And keeps nothing."""

    for cause in sorted(CATALOGUE):
        model = msgspec.structs.replace(RIG_MODEL, effects=[_extended(cause)])
        path = tmp_path / f"{cause}.toml"
        path.write_text(model_text(model))
        loaded = load_model(path)
        assert loaded == model
        simulate(
            VirtualRun(configuration, loaded, RIG_MODEL, scenario, 1, name=str(path)), Nowhere(), Nowhere()
        )


def test_noise_is_what_the_data_were_given(plain: Fit) -> None:
    for name, level in NOISE.items():
        assert plain.sigma[name] == pytest.approx(level, rel=0.1)


@pytest.mark.parametrize(("frames", "likely"), [(1.0, True), (2.004, True), (3.06, False), (0.008, False)])
def test_a_buffer_holds_whole_frames(plain: Fit, frames: float, likely: bool) -> None:
    vector = plain.vector.copy()
    vector[plain.world.space.place["timing.stale_frames"]] = frames
    one = replace(plain, vector=vector, std={"timing.stale_frames": 0.002})
    assert (CAUSES["stale_frame_buffer"].prior_penalty(one) < 1.0) is likely
    assert CAUSES["stale_frame_buffer"].possible(one) is (frames > 0.5)


@pytest.mark.slow
@pytest.mark.parametrize(("hz", "possible"), [(2.5, False), (2.9, False), (6.0, True), (15.0, True)])
def test_a_second_mode_is_none_that_beats_with_the_first(hz: float, possible: bool) -> None:
    """An arm that softens with its amplitude looks like two modes side by side."""
    model = msgspec.structs.replace(
        MODEL, arm=msgspec.structs.replace(MODEL.arm, modes=[*MODEL.arm.modes, Mode(frequency_hz=hz)])
    )
    assert (
        CAUSES["second_bending_mode"].possible(fitted(measured(3.0, 5, {}, model=model), model=model))
        is possible
    )


@pytest.mark.parametrize(
    ("hz", "lead"), [(50.0, 3.0), (120.5, 3.0), (16.7, -2.0), (400.0, -2.0), (37.0, -6.0)]
)
def test_a_hum_is_what_has_the_frequency_of_a_mains_that_is_near(plain: Fit, hz: float, lead: float) -> None:
    """Before any data, against a force on the arm; of rare mains the data must be left to tell."""
    vector = plain.vector.copy()
    for name in ("accelerometer.hum_hz", "arm.periodic_hz"):
        vector[plain.world.space.place[name]] = hz
    one = replace(plain, vector=vector)
    ahead = CAUSES["periodic_disturbance"].prior_penalty(one) - CAUSES["mains_hum"].prior_penalty(one)
    assert ahead >= lead if lead > 0.0 else lead <= ahead < 0.0
