"""The oracle against what can be worked out on paper, and the blind trials drawn with it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.hidden_world.blind import CLEAR_NATS, names_of, prepare
from tests.hidden_world.chance import burst_nats, cells
from tests.hidden_world.draw import draw_case
from tests.hidden_world.effects import CAUSES, UNKNOWN, Effect, wander
from tests.hidden_world.feeler import burst_times
from tests.hidden_world.oracle import Oracle, best_plain, expected_nats, fitted_plain, scale_to
from tests.hidden_world.whitened import whitened
from tests.hidden_world.world import Case, run

pytestmark = pytest.mark.slow
TAKES_TURNS = pytest.mark.blind(each_run=5, group="the oracle")

SECONDS = 8.0


def hidden(name: str, values: dict[str, float], seed: int = 5, detail: float = 0.0) -> Case:
    case = replace(draw_case(seed, None, None, SECONDS), damped=False)
    return replace(case, effects=(Effect(name, values, detail=detail, luck=1),))


def test_nothing_hidden_is_worth_nothing() -> None:
    assert expected_nats(replace(draw_case(5, None, None, SECONDS), effects=())) == 0.0
    assert expected_nats(hidden("cubic_stiffness", {"coefficient_per_m2": 0.0})) == pytest.approx(
        0.0, abs=1e-9
    )


def test_a_hum_is_worth_its_power_over_the_noise() -> None:
    """A sine of amplitude A in N samples of noise s: N A^2 / (4 s^2); at 50 Hz no freedom takes it up."""
    case = hidden("mains_hum", {"frequency_hz": 50.0, "amplitude_m_s2": 0.02})
    feeler = case.rig.feeler
    power = (feeler.hiss**2 + feeler.grain**2 / 12.0) * 4.0
    assert expected_nats(case) == pytest.approx(SECONDS * 1000.0 * 0.02**2 / power, rel=0.02)


def test_a_ramp_of_the_bias_is_worth_what_its_mean_leaves() -> None:
    """The mean of a ramp is the bias's: sum of (r (t - T / 2))^2 / (2 s^2) = r^2 N T^2 / (24 s^2), or a little less."""
    rate = 0.01
    case = hidden("accelerometer_bias_drift", {"rate_m_s3": rate})
    feeler = case.rig.feeler
    worth = rate**2 * SECONDS**3 * 1000.0 / (24.0 * (feeler.hiss**2 + feeler.grain**2 / 12.0))
    assert 0.9 * worth < expected_nats(case) < 1.001 * worth


def test_the_nats_lie_in_the_channel_that_is_touched_and_tell_its_rms() -> None:
    case = hidden("mains_hum", {"frequency_hz": 50.0, "amplitude_m_s2": 0.02})
    shown = Oracle(case).by_channel(case)
    assert max(shown, key=shown.__getitem__) == "acceleration"
    noise = np.hypot(case.rig.feeler.hiss, case.rig.feeler.grain / 12.0**0.5)
    assert shown["acceleration"][1] == pytest.approx(0.02 / 2.0**0.5 / noise, rel=0.02)
    assert sum(nats for nats, _ in shown.values()) == pytest.approx(expected_nats(case), rel=1e-3)


def test_what_the_baseline_may_refit_is_worth_nothing() -> None:
    """A bend that is half a per cent faster from the start is a frequency that is off: no cause."""
    case = hidden("payload_change", {"onset_s": -1.0, "frequency_ratio": 1.001})
    late = hidden("payload_change", {"onset_s": 4.0, "frequency_ratio": 1.001})
    assert Oracle(case).nats() < 0.02 * Oracle(late).nats()


def test_a_scale_of_the_image_is_worth_nothing_however_images_are_weighed() -> None:
    """Where exposures are triggered, those of a moving joint count for less. An image that is larger all over is so by
    the baseline's own scale, which must not be thought to change what each counts for."""
    case = replace(draw_case(6, None, None, SECONDS), effects=(), damped=False)
    case = replace(case, rig=replace(case.rig, eye=replace(case.rig.eye, free=False)))
    clean = run(case)
    base = Oracle(case).base(case, clean.command, len(clean.impact_time))
    centre = case.rig.eye.centre_px
    larger = replace(clean, image=centre + 1.01 * (clean.image - centre))
    difference = whitened(case, larger) - base.at
    assert 0.5 * float(np.sum(difference**2)) > 100.0
    assert 0.5 * float(np.sum(base.left(difference) ** 2)) < 0.01


def test_nats_grow_with_the_square_of_a_small_effect() -> None:
    one, two = (expected_nats(hidden("tracking_drift", {"rate_px_per_s": r})) for r in (0.01, 0.02))
    assert two == pytest.approx(4.0 * one, rel=1e-3)


def test_a_pitch_that_is_off_from_the_start_is_found_by_the_refit_wherever_it_is() -> None:
    """3 % in frequency turn the phase by several turns: far beyond what one linearisation follows."""
    case = hidden("payload_change", {"onset_s": -1.0, "frequency_ratio": 1.03})
    oracle = Oracle(case)
    assert oracle.nats() > 1000.0
    assert oracle.nats(to_the_end=True) < 3.0


@TAKES_TURNS
def test_creep_is_sized_by_what_a_full_refit_leaves() -> None:
    """Far above its rate creep is a little stiffness and damping, which the baseline has: little else is left."""
    case = replace(draw_case(900, "viscoelastic_creep", None, SECONDS), damped=False)
    oracle = Oracle(case)
    sized = scale_to(case, 100.0, 0, oracle)
    assert oracle.nats(sized, to_the_end=True) > 70.0
    assert oracle.nats(sized) > 10.0 * oracle.nats(sized, to_the_end=True)


def test_white_noise_by_chance_is_worth_nothing_and_coloured_noise_what_the_textbook_says() -> None:
    """Coloured: (N ln v - sum ln(1 + K)) / 2 with K of a first-order process; known to the cells' resolution."""
    random = np.random.default_rng(3)
    size = 20000
    white = [random.standard_normal(size) for _ in range(8)]
    for window in (0.5, 2.0, float("inf")):
        assert abs(cells(white, 1000.0, window).nats(0.5)) < 5.0
    slow = [wander(random, size, 0.01, 0.001) for _ in range(8)]
    turn = np.exp(-1j * np.linspace(0.0, np.pi, 20001))
    keep = np.exp(-0.1)
    spectrum = (1.0 - keep**2) / np.abs(1.0 - keep * turn) ** 2
    amount = 0.4
    k = amount**2 * spectrum
    expected = 0.5 * size * (np.log1p(np.mean(k)) - np.mean(np.log1p(k)))
    assert expected > 50.0
    for window in (2.0, float("inf")):
        assert cells(slow, 1000.0, window).nats(amount) == pytest.approx(expected, rel=0.15)


@TAKES_TURNS
def test_a_law_is_worth_less_than_the_course_it_took() -> None:
    for name in ("second_axis", "aliased_gear_mesh", "correlated_bursts"):
        case = scale_to(replace(draw_case(901, name, None, SECONDS), damped=False), 100.0)
        oracle = Oracle(case)
        assert 70.0 < oracle.nats() < 0.7 * oracle._mean_nats(case, 4)


def test_bursts_have_to_be_placed() -> None:
    effect = Effect("correlated_bursts", {"amount": 0.01}, luck=3)
    count = len(burst_times(effect, 20.0))
    assert count > 2
    assert burst_nats(effect, 0.1, 0.1, 20.0) == pytest.approx(-5.0 * count, abs=0.5)
    louder = effect.with_value("amount", 1.0)
    assert burst_nats(louder, 0.1, 0.1, 20.0) > 500.0


@TAKES_TURNS
@pytest.mark.parametrize(
    ("name", "nats"),
    [
        ("cubic_stiffness", 3000.0),
        ("camera_tilt_coupling", 300.0),
        ("delay_drift", 20.0),
        ("mains_hum", 3000.0),
    ],
)
def test_an_effect_is_scaled_to_the_nats_asked_for(name: str, nats: float) -> None:
    case = replace(draw_case(6, name, None, SECONDS), damped=False)
    assert expected_nats(scale_to(case, nats)) == pytest.approx(nats, rel=0.15)


@TAKES_TURNS
@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("cubic_stiffness", {"coefficient_per_m2": 120.0}),
        ("drive_dead_time", {"dead_time_s": 0.0093}),
        ("lens_distortion", {"coefficient_per_px2": 2e-7}),
        ("periodic_disturbance", {"frequency_hz": 7.7, "amplitude_m_s2": 0.2}),
    ],
)
def test_the_plain_form_fits_itself_exactly(name: str, values: dict[str, float]) -> None:
    assert best_plain(hidden(name, values)).values == pytest.approx(values, rel=1e-6)


@TAKES_TURNS
def test_a_rough_form_is_described_by_a_plain_one_that_is_near_and_better() -> None:
    case = hidden("cubic_stiffness", {"coefficient_per_m2": 120.0}, detail=1.0)
    fitted = best_plain(case)
    assert 0.3 * 120.0 < fitted["coefficient_per_m2"] < 120.0


@TAKES_TURNS
def test_a_knee_that_no_small_change_of_a_corner_touches_is_described_by_scanning() -> None:
    """The drive bends off above its soft top; a corner there touches nothing that is commanded."""
    bare = hidden("drive_saturation", {"max_velocity_rad_s": 1.0})
    knee = 1.003 * float(np.max(np.abs(run(replace(bare, effects=())).command)))
    case = hidden("drive_saturation", {"max_velocity_rad_s": knee}, detail=1.0)
    plain, left = fitted_plain(case)
    assert plain["max_velocity_rad_s"] < knee
    assert left < 0.7 * expected_nats(case)


@TAKES_TURNS
@pytest.mark.parametrize("cause", ["drive_saturation", "camera_tilt_coupling", "accelerometer_lag"])
def test_a_blind_trial_hides_what_the_plain_form_describes(cause: str, tmp_path: Path) -> None:
    hidden_there = prepare("one", 1, 31, tmp_path, SECONDS, cause)["hidden"][0]
    assert hidden_there["detail_nats"] <= hidden_there["nats"] / 3.0
    assert 0.0 < hidden_there["detail"] <= 1.0


def test_every_name_has_its_turn_before_any_comes_again() -> None:
    ones = [names_of("one", number, 9)[0] for number in range(2 * len(CAUSES))]
    assert set(ones[: len(CAUSES)]) == set(ones[len(CAUSES) :]) == set(CAUSES)
    assert len(CAUSES) == 29
    assert {names_of("unknown", number, 9)[0] for number in range(len(UNKNOWN))} == set(UNKNOWN)
    assert len(UNKNOWN) >= 8
    for number in range(40):
        first, second = names_of("two", number, 9)
        assert CAUSES[first].where != CAUSES[second].where


def test_a_blind_trial_is_clear_and_its_truth_stays_out_of_the_folder(tmp_path: Path) -> None:
    truth = prepare("one", 4, 77, tmp_path / "data", duration_s=SECONDS)
    assert sorted(path.name for path in (tmp_path / "data").iterdir()) == [
        "fast.csv",
        "frames.csv",
        "model.toml",
    ]
    assert truth["hidden"][0]["nats"] >= CLEAR_NATS
    assert json.loads(json.dumps(truth)) == truth
    again = prepare("one", 4, 77, tmp_path / "again", duration_s=SECONDS)
    assert again == truth
    for name in ("fast.csv", "frames.csv", "model.toml"):
        assert (tmp_path / "data" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def test_nothing_hidden_leaves_noise_alone_as_the_floor(tmp_path: Path) -> None:
    truth = prepare("none", 0, 5, tmp_path, duration_s=SECONDS)
    assert truth["hidden"] == [] and truth["strongest"] is None
    assert set(truth["floor"]) == {
        "acceleration_m_s2",
        "joint_position_rad",
        "joint_velocity_rad_s",
        "displacement_px",
    }
    assert all(0.0 < value < 1.0 and np.isfinite(value) for value in truth["floor"].values())
