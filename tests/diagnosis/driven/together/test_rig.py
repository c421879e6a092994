"""Recordings of one rig, of which some hold what the others do not."""

from pathlib import Path

import pytest

from stillarm.common.recording.reader import open_recording
from stillarm.diagnosis.driven.recording.signals import read_driven
from stillarm.diagnosis.driven.together.rig import RigResult, diagnose_rig
from tests.fixtures.current_joint import SAMPLES, write_recording

LABELS = ("a", "b", "c")


def _diagnosed(
    folder: Path,
    coulomb: tuple[float, ...],
    inertia: tuple[float, ...] = (1.0, 1.0, 1.0),
    samples: int = SAMPLES,
) -> RigResult:
    paths = [
        write_recording(
            folder / f"{name}.mcap", coulomb[k], 0.0, inertia[k], 10 + k, zero=0.2 * k, samples=samples
        )
        for k, name in enumerate(LABELS[: len(coulomb)])
    ]
    return diagnose_rig([read_driven(open_recording(one)) for one in paths], LABELS[: len(coulomb)], None)


@pytest.mark.blind(each_run=2, group="driven joints")
def test_friction_in_one_recording_is_named_there_alone(tmp_path: Path) -> None:
    result = _diagnosed(tmp_path, (0.0, 4.0, 0.0))
    (one,) = result.rig.table["findings"]
    assert (one["cause"], one["only_in"], one["indistinguishable_from"]) == (
        "joint_coulomb_friction",
        ["b"],
        [],
    )
    assert one["parameters"]["coulomb"]["value"] == pytest.approx(4.0, rel=0.02)
    assert [view["verdict"] for view in result.views] == ["none", "named", "none"]
    assert [row["worse"] for row in result.rig.table["recordings"]] == [False, False, False]


@pytest.mark.blind(each_run=2, group="driven joints")
def test_friction_in_all_and_a_load_in_one(tmp_path: Path) -> None:
    result = _diagnosed(tmp_path, (2.0, 2.0, 2.0), (1.0, 1.0, 1.3), SAMPLES // 2)
    found = {one["cause"]: one for one in result.rig.table["findings"]}
    friction = found["joint_coulomb_friction"]
    assert "only_in" not in friction and friction["holds_in"] == ["a", "b", "c"]
    assert friction["parameters"]["coulomb"]["value"] == pytest.approx(2.0, rel=0.1)
    load = found["inertia_change"]
    assert load["only_in"] == ["c"] and load["form"] == "against the other recordings"
    assert load["parameters"]["inertia_excess"]["value"] == pytest.approx(0.3, rel=0.1)


@pytest.mark.slow
def test_recordings_that_differ_in_their_zeros_alone_have_nothing(tmp_path: Path) -> None:
    """In half the time that the others take: the zeros are 200 deviations of a sample apart."""
    result = _diagnosed(tmp_path, (0.0, 0.0), samples=SAMPLES // 2)
    assert result.rig.table["verdict"] == "none" and result.rig.table["findings"] == []
