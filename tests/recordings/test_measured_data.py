"""Each measured set goes through import, replay and diagnose, wherever ../shared/data is."""

from pathlib import Path

import pytest

from tests.recordings.measured_sets import DATA, ROBOT_ARM_HZ, SETS
from tests.recordings.outcome import call, check_diagnosis, diagnosis_of, fault_of

BUDGET_S = 2.0

pytestmark = [
    pytest.mark.hardware_data,
    pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data is not there"),
]


@pytest.mark.parametrize(
    ("name", "rate_hz", "cycles_per_sample", "within"),
    [
        ("tuning fork", 250.0 / 5.0, 32.0 / 250.0, 1e-3),
        ("robot arm", ROBOT_ARM_HZ, 0.1260, 1e-3),
    ],
)
def test_a_known_resonance_is_fitted(
    name: str, rate_hz: float, cycles_per_sample: float, within: float, tmp_path: Path
) -> None:
    """The fork is driven at 32 Hz and filmed at 250 frames a second; the robot arm's largest resonance is published."""
    one = SETS[name]
    (tmp_path / "data").mkdir()
    recording = tmp_path / "recording.mcap"
    assert call([*one.make(DATA / one.source, tmp_path / "data"), "-o", str(recording)]).status == 0
    found = call(["diagnose", str(recording), "--no-use", "--out", str(tmp_path / "diagnosis")])
    assert found.status == 0, found.error
    table = diagnosis_of(tmp_path)
    check_diagnosis(table)
    fitted = table["baseline_changes"]["arm.modes[0].frequency_hz"]["fitted"]
    assert fitted / rate_hz == pytest.approx(cycles_per_sample, abs=within)


def test_the_silverbox_has_a_cubic_spring(tmp_path: Path) -> None:
    """Coefficient about 3.9, and the held-out error cut by over nine tenths."""
    one = SETS["silverbox, growing noise"]
    (tmp_path / "data").mkdir()
    recording = tmp_path / "recording.mcap"
    assert call([*one.make(DATA / one.source, tmp_path / "data"), "-o", str(recording)]).status == 0
    found = call(["diagnose", str(recording), "--no-use", "--out", str(tmp_path / "diagnosis")])
    assert found.status == 0, found.error
    table = diagnosis_of(tmp_path)
    assert table["verdict"] == "named"
    first = table["findings"][0]
    assert first["cause"] == "cubic_stiffness"
    assert first["parameters"]["coefficient_per_m2"]["value"] == pytest.approx(3.9, abs=0.2)
    assert first["held_out"]["reduction"] > 0.9


@pytest.mark.blind(each_run=5)
@pytest.mark.parametrize("name", SETS)
def test_a_measured_set_is_imported_and_diagnosed(name: str, tmp_path: Path) -> None:
    one = SETS[name]
    (tmp_path / "data").mkdir()
    recording = tmp_path / "recording.mcap"
    imported = call([*one.make(DATA / one.source, tmp_path / "data"), "-o", str(recording)])
    assert imported.status == 0, imported.error
    folder = str(tmp_path / "diagnosis")
    found = call(["diagnose", str(recording), "--no-use", "--budget-s", str(BUDGET_S), "--out", folder])
    assert fault_of(found) is None
    if one.refused:
        assert found.status == 1 and one.refused in found.error
        return
    assert found.status == 0, found.error
    check_diagnosis(diagnosis_of(tmp_path))
