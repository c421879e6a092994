"""Each measured set goes through import, replay and diagnose, wherever ../shared/data is."""

from pathlib import Path

import pytest

from tests.recordings.measured_sets import DATA, SETS
from tests.recordings.outcome import call, check_diagnosis, diagnosis_of, fault_of

BUDGET_S = 2.0

pytestmark = [
    pytest.mark.hardware_data,
    pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data is not there"),
]


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
