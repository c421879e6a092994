"""Cases come from their seeds, and each cause changes what its recording shows by what the truth says."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.hidden_world.driven.case import FAINTEST, LARGEST, make, tells_scales
from tests.hidden_world.driven.draw import KINDS, draw_rig
from tests.hidden_world.driven.effects import CAUSES, SENSOR_CAUSES
from tests.hidden_world.driven.files import write_case
from tests.hidden_world.driven.recording import record
from tests.hidden_world.driven.score import right, score
from tests.hidden_world.driven.write import planned

pytestmark = pytest.mark.slow
SHORT_S = 10.0


@pytest.mark.parametrize("cause", CAUSES)
def test_a_cause_changes_the_data_by_its_stated_size(cause: str) -> None:
    """Without a refit the change is at least what is left after one; the largest channel is what the truth states."""
    case = make(17, cause, SHORT_S)
    assert case.effect is not None and FAINTEST <= case.shows <= LARGEST
    with_it = record(case.rig, case.effect, noise=False)
    without = record(case.rig, noise=False)
    for channel in case.rig.channels:
        noise = max(channel.noise, channel.quantum / np.sqrt(12.0))
        apart = with_it.channels[channel.kind] - without.channels[channel.kind]
        assert np.sqrt(np.mean(apart**2)) / noise == pytest.approx(case.raw[channel.kind], rel=1e-9)
    of = case.raw if CAUSES[cause].stated else case.seen
    assert case.shows == max(of.values())
    assert case.rig.stated or not CAUSES[cause].stated
    assert len(case.rig.channels) >= (2 if cause in SENSOR_CAUSES else 1)


def test_noise_is_what_the_channel_states() -> None:
    rig, _ = draw_rig(8, "none", longest_s=SHORT_S)
    noisy, clean = record(rig), record(rig, noise=False)
    for channel in rig.channels:
        rest = noisy.channels[channel.kind] - clean.channels[channel.kind]
        stated = np.hypot(channel.noise, channel.quantum / np.sqrt(12.0))
        assert np.std(rest) == pytest.approx(stated, rel=0.15)


def test_a_seed_gives_the_same_files(tmp_path: Path) -> None:
    for name in ("once", "again"):
        write_case(make(5, "torque_offset", SHORT_S), tmp_path / name)
    files = sorted(p.name for p in (tmp_path / "once").iterdir())
    assert len(files) >= 3
    for file in files:
        assert (tmp_path / "once" / file).read_bytes() == (tmp_path / "again" / file).read_bytes()


def test_rigs_are_of_all_kinds() -> None:
    rigs = [draw_rig(seed, "none", longest_s=5.0)[0] for seed in range(30)]
    assert {r.drive.kind for r in rigs} == set(KINDS)
    assert {r.arm.modes for r in rigs} == {0, 1, 2}
    assert {r.excitation.closed for r in rigs} == {True, False}
    assert {r.drive.log_unit for r in rigs} == {"si", "counts", "percent"}
    assert {r.drive.gear_ratio > 1.0 for r in rigs} == {True, False}


def test_a_scale_is_hidden_only_where_it_can_be_told() -> None:
    """One sensor of known unit beside a command of none: the command's unit makes up for its scale."""
    rig = make(17, "sensor_scale", SHORT_S).rig
    assert tells_scales(rig)
    alone = replace(rig.channels[0], unit="rad"), replace(rig.channels[0], unit="strain_v")
    for unit, told in (("counts", False), ("si", True)):
        drive = replace(rig.drive, log_unit=unit)
        assert tells_scales(replace(rig, drive=drive, channels=alone)) is told
    both = replace(rig.channels[0], unit="rad"), replace(rig.channels[0], unit="m/s2")
    assert tells_scales(replace(rig, drive=replace(rig.drive, log_unit="counts"), channels=both))


def test_every_cause_is_hidden_as_often_as_the_others() -> None:
    plan = planned(60, 1, none=30)
    assert len(plan) == 90 and plan.count("none") == 30
    assert {plan.count(cause) for cause in CAUSES} <= {4, 5}
    assert planned(60, 1, 30) == plan != planned(60, 2, 30)


def answer(verdict: str, *findings: tuple[str, list[str]]) -> dict[str, object]:
    return {
        "verdict": verdict,
        "findings": [{"cause": c, "indistinguishable_from": others} for c, others in findings],
    }


TRUTH = {"expected": "named", "cause": "sensor_lag", "size_in_noise": 5.0}


@pytest.mark.parametrize(
    "given, good",
    [
        (answer("named", ("sensor_lag", [])), True),
        (answer("named", ("channel_delay", ["sensor_lag"])), True),
        (answer("named", ("sensor_lag", ["channel_delay", "drive_dead_time"])), False),
        (answer("named", ("channel_delay", []), ("sensor_lag", [])), False),
        (answer("unexplained", ("sensor_lag", [])), False),
        (answer("none"), False),
        (None, False),
    ],
)
def test_the_first_finding_has_to_name_the_cause(given: dict[str, object] | None, good: bool) -> None:
    assert right(TRUTH, given) is good
    assert right(TRUTH | {"expected": "none", "cause": None}, given) is (given == answer("none"))


def test_the_score_counts_what_is_there_and_what_is_missing(tmp_path: Path) -> None:
    for number in (1, 2):
        (tmp_path / f"out/case_000{number}").mkdir(parents=True)
        (tmp_path / f"out/case_000{number}/truth.json").write_text(json.dumps(TRUTH))
    (tmp_path / "results/case_0001").mkdir(parents=True)
    (tmp_path / "results/case_0001/diagnosis.json").write_text(
        json.dumps(answer("named", ("sensor_lag", [])))
    )
    lines = score(tmp_path / "out", tmp_path / "results")
    assert any(line.startswith("case_0002") and "no answer" in line for line in lines)
    assert any(line.split() == ["named", "1", "of", "2"] for line in lines)
    with pytest.raises(SystemExit, match=r"no case_\*"):
        score(tmp_path / "nowhere", tmp_path / "results")


def test_a_clean_case_hides_nothing() -> None:
    case = make(4, "none", SHORT_S)
    assert case.effect is None and case.shows == 0.0
    again = record(replace(case.rig))
    assert all(np.array_equal(again.channels[k], v) for k, v in case.recording.channels.items())
