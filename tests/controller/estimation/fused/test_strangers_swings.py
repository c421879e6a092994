"""`fused` on recordings of another world (tests/hidden_world/swings): right, and honest, whatever began the swing.

Every case is one that an estimator told everything would have within 0.15 %, so that 0.5 % is to be had.
"""

from dataclasses import replace
from pathlib import Path

import pytest

from stillarm.benchmarks.live.replay_tables import read_estimates
from stillarm.benchmarks.live.scoring import score
from stillarm.benchmarks.live.truth import Swing, TrueRun
from stillarm.common.csv_bundle.bundle_import import import_bundle
from stillarm.common.recording.reader import open_recording
from stillarm.controller.replay.replay import read_run, replay_method
from stillarm.controller.replay.replay_tables import write_tables
from tests.hidden_world.swings.bundle import write_bundle
from tests.hidden_world.swings.informed import informed_error
from tests.hidden_world.swings.plain import draw_plain
from tests.hidden_world.swings.sensors import Recording, make

MEAN, LARGEST, HONEST, SETTLED_S, DELAY_RMS_S = 0.005, 0.05, 3.0, 1.5, 1e-3
_TOLD_ALL = 0.0015
_STRIDE = 20  # grid points of the motion: 2 ms

KEPT = (1000, 1001, 1002, 1011, 1015, 1016, 1018, 1019, 1020, 1021)
MISSED = {
    1007: "largest 5.9 %",
    1014: "mean 0.75 %, largest 6.8 %, delay 1.1 ms, normalised errors squared 10.4 and 4.9, settled after 5.5 s",
}
"""What each misses, and by how much; a case that keeps all moves up."""
TAKES_TURNS = pytest.mark.blind(each_run=3, seed=1000, group="a stranger's swings")


@TAKES_TURNS
@pytest.mark.parametrize("seed", KEPT)
def test_a_strangers_swings_are_followed(seed: int, tmp_path: Path) -> None:
    assert _missed(seed, tmp_path) == {}


@pytest.mark.slow
@TAKES_TURNS
@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(seed, marks=pytest.mark.xfail(reason=why, strict=True, raises=AssertionError))
        for seed, why in MISSED.items()
    ],
)
def test_those_that_are_missed(seed: int, tmp_path: Path) -> None:
    assert _missed(seed, tmp_path) == {}


@pytest.mark.slow
def test_a_pull_is_followed_though_a_random_force_seems_to_be_learnt(tmp_path: Path) -> None:
    """What the images show of the pull before it is found teaches a random force, which the accelerometer denies. Where
    such a force was believed none that lasts could begin, and the mean error was 420 %."""
    assert (_scores(make(draw_plain(3007)), tmp_path)["error_mean"] or 0.0) < 0.02


@pytest.mark.slow
def test_a_pull_is_followed_though_the_scale_seems_to_drift(tmp_path: Path) -> None:
    """A force in time with the vibration raises the alarm of the scale. Where the scale kept the room that it was given
    then, it took later pulls, and the mean error was 9.5 %."""
    assert (_scores(make(draw_plain(3009)), tmp_path)["error_mean"] or 0.0) < 0.01


@pytest.mark.slow
def test_no_force_is_left_behind_where_the_dates_were_wrong(tmp_path: Path) -> None:
    """Dates are moved while a force is held. What was held then stayed in the deflection, with no deviation of its own,
    and the normalised error squared was 48."""
    assert (
        _scores(make(draw_plain(4014)), tmp_path)["deflection_normalised_error_squared_max"] or 0.0
    ) < HONEST


@pytest.fixture(scope="module")
def of_sampled_late(tmp_path_factory: pytest.TempPathFactory) -> dict[str, float | None]:
    """Of a stranger's rig whose accelerometer is sampled half a cycle before it is read."""
    case = draw_plain(5002)
    late = replace(case, accelerometer=replace(case.accelerometer, age_s=0.0005))
    return _scores(make(late), tmp_path_factory.mktemp("late"))


@pytest.mark.slow
def test_a_sensor_sampled_half_a_cycle_ago_is_in_the_deviation(
    of_sampled_late: dict[str, float | None],
) -> None:
    """Delay and deflection are then half a cycle off, together. Said of the delay alone, the deflection's normalised
    error squared was 70."""
    assert (of_sampled_late["deflection_normalised_error_squared_max"] or 0.0) < HONEST
    assert (of_sampled_late["delay_rms_s"] or 0.0) < 0.6e-3


@pytest.mark.slow
@pytest.mark.xfail(reason="delay's normalised error squared 3.08", strict=True, raises=AssertionError)
def test_a_sensor_sampled_half_a_cycle_ago_is_in_the_delays_deviation(
    of_sampled_late: dict[str, float | None],
) -> None:
    """The half cycle that nothing shows is nearly two of the deviations stated after 8 s."""
    assert (of_sampled_late["delay_normalised_error_squared_max"] or 0.0) < HONEST


def _missed(seed: int, folder: Path) -> dict[str, float | None]:
    """The figures that are beyond what is asked, of a seed whose figures are to be had."""
    recording = make(draw_plain(seed))
    if informed_error(recording) > _TOLD_ALL:  # no assertion: an expected failure would hide it
        raise ValueError(f"seed {seed}: an estimator told everything would miss it, too")
    got = _scores(recording, folder)
    asked = {
        "lost_share": 0.0,
        "error_mean": MEAN,
        "error_max": LARGEST,
        "delay_rms_s": DELAY_RMS_S,
        "delay_normalised_error_squared_max": HONEST,
        "deflection_normalised_error_squared_max": HONEST,
        "settled_s": SETTLED_S,
    }
    return {name: got[name] for name, most in asked.items() if not (got[name] or 0.0) <= most}


def _scores(recording: Recording, folder: Path) -> dict[str, float | None]:
    """Import, replay and score, as the commands do."""
    write_bundle(recording, folder / "bundle")
    import_bundle(folder / "bundle", folder / "recording.mcap")
    run = read_run(open_recording(folder / "recording.mcap"))
    write_tables([replay_method(run, "fused")], folder)
    motion, seen = recording.motion, recording.images
    truth = TrueRun(
        motion.time_s[::_STRIDE],
        motion.deflection_m[::_STRIDE],
        dict(zip(seen.number.tolist(), seen.middle_s.tolist(), strict=True)),
        tuple(Swing(begin, end) for begin, end in recording.swings_s),
    )
    return score(read_estimates(folder)["fused"], truth)
