"""The procedure from the first nudge to the verdict: rigs that take turns, and rigs that show too little."""

from dataclasses import replace
from math import nan
from pathlib import Path

import msgspec
import numpy as np
import pytest

from stillarm.benchmarks.commissioning import (
    UNDAMPED,
    assumed_model,
    commission_virtually,
    draw_rig,
    simulated,
    truth_of,
)
from stillarm.common.files.model import Arm, Mode, Model
from stillarm.common.files.scenario import Scenario
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.diagnosis.calibration.start_values import Start, start_values
from stillarm.diagnosis.commissioning import procedure
from stillarm.diagnosis.commissioning.plan import Limits, probe, within
from stillarm.diagnosis.commissioning.procedure import commission, until
from stillarm.diagnosis.commissioning.verdict import CommissioningVerdict, marked
from stillarm.diagnosis.commissioning.watch import Bounds
from stillarm.diagnosis.data.measured import Frames, Measured
from stillarm.diagnosis.data.reading import read_measured

LIMITS = Limits()
RIGS = (1, 7, 8)


@pytest.mark.blind(each_run=1, seed=RIGS)
@pytest.mark.parametrize("seed", RIGS)
def test_a_rig_of_random_parameters_is_identified_from_a_model_that_knows_none(
    seed: int, tmp_path: Path
) -> None:
    """Judged by the truth alone: errors within the stated deviations and the bounds asked for, signs right."""
    true = draw_rig(seed)
    done = commission_virtually(true, assumed_model(), seed, tmp_path)
    truth = truth_of(true)
    sizes = {key: abs(value - truth[key]) / std for key, (value, std) in done.found.parameters.items()}
    assert set(sizes) == set(truth)
    assert sum(size <= 3.0 for size in sizes.values()) >= len(sizes) - 1 and max(sizes.values()) < 5.0
    found = truth_of(done.found.model)
    for key, most in (
        ("arm.modes[0].frequency_hz", 0.005),
        ("arm.modes[0].damping_ratio", 0.15),
        ("accelerometer.scale", 0.02),  # signed: a wrong sign is an error of 200 %
        ("camera.scale_px_per_m", 0.02),
    ):
        assert found[key] == pytest.approx(truth[key], rel=most)
    assert done.verdict.good and "\n" not in done.verdict.text
    model = marked(done.found.model, done.found, "2026-01-31", "moves.mcap")
    assert model.identified and model.commissioned.std["arm.modes[0].frequency_hz"] > 0.0  # type: ignore[union-attr]


def still(name: str, scenario: Scenario, bounds: Bounds, images: bool = True) -> Measured:
    """What a rig shows whose joint does not obey: noise."""
    del bounds
    random = np.random.default_rng(len(name))
    n = round(scenario.duration_s / 0.001)
    command = np.array([scenario.reference_rad_s(0.001 * k) for k in range(n)])
    at = np.arange(0, n if images else 0, 15)
    time = np.asarray(0.001 * at, dtype=np.float64)
    frames = Frames(
        at // 15, time, time - 0.05, 0.05 * random.standard_normal(len(at)), np.full(len(at), nan)
    )
    return Measured(
        name, 0.001, 0.0, command, command, 0.3 * random.standard_normal(n), np.zeros(n), np.zeros(n),
        np.zeros(n), np.full(n, nan), frames, np.empty(0),
    )  # fmt: skip


@pytest.mark.slow
def test_a_joint_that_does_not_move_is_told() -> None:
    with pytest.raises(UserError, match="left no vibration") as refused:
        commission(still, assumed_model(), LIMITS)
    assert "\n" not in str(refused.value)


def test_a_probe_in_which_the_first_move_is_too_much_goes_no_further() -> None:
    """And says what was too much, before anything faster is tried."""
    names = []

    def rough(name: str, scenario: Scenario, bounds: Bounds) -> Measured:
        names.append(name)
        measured = still(name, scenario, bounds)
        return replace(measured, acceleration=100.0 * measured.acceleration)

    with pytest.raises(UserError, match=r"even the smallest move .* accelerometer shows"):
        commission(rough, assumed_model(), LIMITS)
    assert names == ["probe"]


def test_a_model_without_length_is_refused_before_anything_moves() -> None:
    def never(name: str, scenario: Scenario, bounds: Bounds) -> Measured:
        raise AssertionError("moved")

    with pytest.raises(UserError, match="length_m"):
        commission(never, Model(arm=Arm(modes=[Mode()])), LIMITS)
    slow = msgspec.structs.replace(
        assumed_model(), drive=msgspec.structs.replace(assumed_model().drive, max_velocity_rad_s=0.001)
    )
    with pytest.raises(UserError, match="no room"):
        commission(never, slow, LIMITS)


def test_the_beginning_of_a_recording() -> None:
    whole = still("x", Scenario(duration_s=4.0), Bounds(1.0, 1.0, 1.0))
    part = until(whole, 1.5)
    assert part.cycles == 1500 and part.duration_s == 1.5
    assert len(part.frames) == 100 and part.frames.received_s[-1] < 1.5


@pytest.fixture(scope="module")
def probed(tmp_path_factory: pytest.TempPathFactory) -> Measured:
    """The probe of a rig that is well."""
    scenario = probe(within(LIMITS, assumed_model().drive))
    folder = tmp_path_factory.mktemp("probe")
    path, _ = simulated(draw_rig(100), assumed_model(), scenario, 1, folder, UNDAMPED)
    return read_measured(open_recording(path), assumed_model())


@pytest.fixture(scope="module")
def rough(probed: Measured) -> Start:
    """What the whole probe shows: the rigs that take turns judge it."""
    found = start_values(probed, assumed_model())
    assert found is not None
    return found


def shaken(name: str, scenario: Scenario, bounds: Bounds) -> Measured:
    """Moves in which the image leaves its bound, and which end there."""
    measured = still(name, scenario, bounds)
    measured.frames.displacement_px[300:] += 500.0
    return until(measured, 5.0)


@pytest.mark.slow
def test_moves_that_are_cut_short_name_what_was_exceeded(
    probed: Measured, rough: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A rig that is well through the probe and shakes in the moves: no model."""

    def record(name: str, scenario: Scenario, bounds: Bounds) -> Measured:
        return probed if name == "probe" else shaken(name, scenario, bounds)

    monkeypatch.setattr(procedure, "start_values", lambda measured, model: rough)
    with pytest.raises(UserError, match=r"ended after 5 of \d+ s: the image has moved by 500 px"):
        commission(record, assumed_model(), LIMITS)


class Fitted(Exception):
    """With the moves that the model would be fitted to."""


@pytest.mark.slow
def test_moves_that_a_bound_ends_are_made_once_more_slower(
    probed: Measured, rough: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rig is well; the moves were planned by a rough model. What is fitted to is the second recording; the fit is
    that of the rigs that take turns."""
    told, fastest = list[str](), dict[str, float]()

    def record(name: str, scenario: Scenario, bounds: Bounds) -> Measured:
        fastest[name] = max(abs(one.velocity_rad_s) for one in scenario.moves)
        if name == "probe":
            return probed
        return shaken(name, scenario, bounds) if name == "moves" else still(name, scenario, bounds)

    def fitted(measured: Measured, *_: object) -> None:
        raise Fitted(measured)

    rests: list[float] = []
    monkeypatch.setattr(procedure, "start_values", lambda measured, model: rough)
    monkeypatch.setattr(procedure, "calibrate", fitted)
    with pytest.raises(Fitted) as ended:
        commission(record, assumed_model(), LIMITS, rest=rests.append, tell=told.append)
    (measured,) = ended.value.args
    assert len(rests) == 1 and 1.0 < rests[0] <= 60.0
    assert fastest["moves_slower"] == pytest.approx(0.6 * fastest["moves"])
    assert any("once more, at 0.6 of the velocity" in line for line in told)
    assert measured.name == "moves_slower" and measured.duration_s > 10.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("missed_s", "names"),
    [
        ((0.0,), ["moves"]),
        ((0.2, 0.0), ["moves", "moves_again_1"]),
        ((0.2, 0.1, 0.3), ["moves", "moves_again_1", "moves_again_2"]),
    ],
)
def test_moves_in_which_cycles_were_missed_are_made_again_where_the_model_is_not_good(
    missed_s: tuple[float, ...],
    names: list[str],
    probed: Measured,
    rough: Start,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Twice at most; the last ones are judged."""
    moved, told, rests = list[str](), list[str](), list[float]()
    verdicts = iter(CommissioningVerdict(missed == 0.0, "not good; why", missed) for missed in missed_s)

    def record(name: str, scenario: Scenario, bounds: Bounds) -> Measured:
        if name == "probe":
            return probed
        moved.append(name)
        return still(name, scenario, bounds)

    monkeypatch.setattr(procedure, "start_values", lambda measured, model: rough)
    monkeypatch.setattr(procedure, "calibrate", lambda *given: None)
    monkeypatch.setattr(procedure, "judge", lambda found, measured: next(verdicts))
    done = commission(record, assumed_model(), LIMITS, rest=rests.append, tell=told.append)
    assert moved == names
    assert done.measured.name == names[-1]
    assert len(rests) == len(names) - 1
    assert sum("the moves once more" in line for line in told) == len(names) - 1
    assert done.verdict.good == (missed_s[-1] == 0.0)
