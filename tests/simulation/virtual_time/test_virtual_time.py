"""The loop in virtual time: deterministic, replayed to the same numbers, and it damps."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.controller.replay.replay import compare_with_live, read_run, replay_method
from stillarm.simulation.demo.scoring import damping_scores, method_scores
from stillarm.simulation.demo.truth_file import read_truth
from stillarm.simulation.virtual_time.simulated_recording import write_simulated_recording

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
MODEL = ROOT / "configs" / "model.toml"
SCENARIO = """
duration_s = 13.0
strikes = [{time_s = 1.0, deflection_m = 0.00625}, {time_s = 10.0, deflection_m = 0.00625}]
damping = [{on_s = 9.8, off_s = 13.0}]
moves = [{start_s = 8.8, end_s = 9.3, velocity_rad_s = 0.05}]
"""


def simulated(
    folder: Path, seed: int = 3, images: bool = False, scenario: str = SCENARIO, model: Path = MODEL
) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "scenario.toml").write_text(scenario)
    write_simulated_recording(
        true_model_path=model,
        assumed_model_path=model,
        scenario_name=str(folder / "scenario.toml"),
        seed=seed,
        recording_path=folder / "rec.mcap",
        truth_path=folder / "truth.mcap",
        images=images,
    )
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulated(tmp_path_factory.mktemp("simulated"))


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes_and_another_gives_others(run: Path, tmp_path: Path) -> None:
    """Recording and truth, in another folder; what another seed changes, its first seconds show."""
    begins = SCENARIO.replace("duration_s = 13.0", "duration_s = 2.0")
    again = simulated(tmp_path / "again")
    first, other = (simulated(tmp_path / f"seed {seed}", seed, scenario=begins) for seed in (3, 2))
    for name in ("rec.mcap", "truth.mcap"):
        assert (run / name).read_bytes() == (again / name).read_bytes()
        assert (first / name).read_bytes() != (other / name).read_bytes()
    felt = [
        [row.acceleration_m_s2 for row in read_run(open_recording(one / "rec.mcap")).fast]
        for one in (first, other)
    ]
    assert felt[0][:10] != felt[1][:10]  # not in the header alone, which states the seed


@pytest.mark.slow
def test_replay_gives_the_same_numbers(run: Path) -> None:
    """Every delay, prediction and command of the controller; and a changed measurement would be noticed."""
    recorded = read_run(open_recording(run / "rec.mcap"))
    comparison = compare_with_live(recorded)
    assert comparison.cycles == 13000
    assert comparison.identical, comparison.first_difference
    wrong = recorded.frames[100]
    recorded.frames[100] = type(wrong)(
        **{f: getattr(wrong, f) for f in wrong.__struct_fields__}
        | {"displacement_px": wrong.displacement_px + 1.0}
    )
    assert compare_with_live(recorded).different > 0


def test_the_delay_is_found_and_the_arm_is_stilled(run: Path) -> None:
    """Against the truth: correlation beats timestamps by half, and damping settles in a fraction of the free time."""
    recorded = read_run(open_recording(run / "rec.mcap"))
    truth = read_truth(run / "truth.mcap", 0.0)
    assert [round(s, 3) for s in truth.strikes_s] == [1.0, 10.0]
    scores = {
        name: method_scores(replay_method(recorded, name), truth, recorded.model)
        for name in ("timestamps", "correlation")
    }
    assert (
        scores["correlation"]["prediction_error_mean"] < 0.5 * scores["timestamps"]["prediction_error_mean"]
    )
    assert scores["correlation"]["prediction_error_mean"] < 0.035
    assert scores["correlation"]["delay_error_rms_s"] < 0.007
    damping = damping_scores(truth, recorded.model, 8.8)
    assert damping["damping_ratio_free"] == pytest.approx(0.01, rel=0.02)
    assert damping["damping_ratio_damped"] is not None and damping["damping_ratio_damped"] > 0.08
    assert damping["settling_time_damped_s"] is not None and damping["settling_time_damped_s"] < 2.5


def test_the_capture_delay_is_the_models(run: Path) -> None:
    """Mean about 74 ms over this run; the wander leaves some milliseconds to chance."""
    recorded = read_run(open_recording(run / "rec.mcap"))
    truth = read_truth(run / "truth.mcap", 0.0)
    delays = [f.received_s - truth.mid_exposure_s[f.frame] for f in recorded.frames]
    assert np.mean(delays) == pytest.approx(0.074, abs=0.015)
    assert all(f.received_s >= f.started_s for f in recorded.frames)


@pytest.mark.slow
def test_with_images_the_tracker_takes_the_error_models_place(tmp_path: Path) -> None:
    """Rendered and tracked, the displacement is that of the truth to a twentieth of a pixel."""
    folder = simulated(
        tmp_path / "images",
        images=True,
        scenario="duration_s = 2.0\nstrikes = [{time_s = 0.3, deflection_m = 0.004}]",
    )
    recorded = read_run(open_recording(folder / "rec.mcap"))
    truth = read_truth(folder / "truth.mcap", 0.0)
    assert len(recorded.frames) > 110
    assert all(frame.status == 0 for frame in recorded.frames)
    mids = np.array([truth.mid_exposure_s[f.frame] for f in recorded.frames])
    wanted = -800.0 * np.interp(mids, truth.time_s, truth.deflection_m)
    found = np.array([f.displacement_px for f in recorded.frames])
    error = found - wanted
    smear = mids < 0.29  # a frame exposed across the impact is no sample of a smooth motion
    error = error[smear | (mids > 0.32)]
    assert np.std(error) < 0.05


@pytest.mark.slow
def test_a_triggered_camera_is_asked_for_each_frame(tmp_path: Path) -> None:
    """Four requests under way: the timestamp of a frame is that of its request, before its exposure."""
    (tmp_path / "triggered.toml").write_text("[arm]\nlength_m = 2.0\n[camera]\nmode = 'triggered'\n")
    folder = simulated(
        tmp_path / "run", scenario="duration_s = 4.0\nstrikes = []", model=tmp_path / "triggered.toml"
    )
    recorded = read_run(open_recording(folder / "rec.mcap"))
    truth = read_truth(folder / "truth.mcap", 0.0)
    assert len(recorded.frames) > 100
    assert [f.frame for f in recorded.frames] == list(range(len(recorded.frames)))
    for frame in recorded.frames:
        exposed_from = truth.mid_exposure_s[frame.frame] - 0.5 * 0.015
        assert frame.started_s <= exposed_from + 0.001


TORQUE_MODEL = """
[arm]
length_m = 2.0
[[arm.modes]]
modal_mass_kg = 0.2
[drive]
kind = "current"
inertia_kg_m2 = 3.0
torque_per_input = 2.5
coulomb_n_m = 0.3
viscous_n_m_s = 0.5
input_limit = 20.0
bandwidth_hz = 10.0
"""


@pytest.mark.slow
def test_a_joint_that_a_current_drives_is_damped_through_our_velocity_loop(tmp_path: Path) -> None:
    """It moves as it is told, and settles sooner; the controller replays to the same numbers."""
    (tmp_path / "model.toml").write_text(TORQUE_MODEL)
    folder = simulated(tmp_path / "run", model=tmp_path / "model.toml")
    recorded = read_run(open_recording(folder / "rec.mcap"))
    assert compare_with_live(recorded).identical
    moved = [row.joint_velocity_rad_s for row in recorded.fast if 8.9 < row.time_s < 9.25]
    assert np.mean(moved) == pytest.approx(0.05, rel=0.1)
    bent = open_recording(folder / "truth.mcap").columns("/truth/state")["deflection_m"]
    free, damped = (np.abs(bent[at : at + 800]).max() for at in (3200, 12200))
    assert damped < 0.3 * free


@pytest.mark.slow
def test_rig_and_controller_of_other_kinds_of_drive_are_refused(tmp_path: Path) -> None:
    (tmp_path / "model.toml").write_text(TORQUE_MODEL)
    with pytest.raises(
        UserError, match=r'drive\.kind = "current" of the rig and "velocity" of the controller'
    ):
        write_simulated_recording(
            true_model_path=tmp_path / "model.toml",
            assumed_model_path=MODEL,
            scenario_name="demo",
            seed=1,
            recording_path=tmp_path / "rec.mcap",
            truth_path=tmp_path / "truth.mcap",
            images=False,
        )
