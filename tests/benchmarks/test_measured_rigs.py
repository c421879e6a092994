"""The figures of docs/measured-rigs.md, wherever ../shared/data is; others are in test_rubbing, test_subspace_peer."""

import re
from pathlib import Path

import numpy as np
import pytest

from stillarm.benchmarks.identification import compare
from stillarm.benchmarks.identification_data import f16, silverbox
from stillarm.benchmarks.identification_driven import as_driven
from stillarm.benchmarks.measured_rigs import SETS
from tests.conftest import DATA
from tests.fixtures.imports import ROOT

PAGE = (ROOT / "docs" / "measured-rigs.md").read_text()


def told(data: str, method: str) -> float:
    """The held-out error that the page's table gives."""
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in PAGE.splitlines() if "|" in line]
    begins = next(k for k, row in enumerate(rows) if row[0].startswith(data))
    row = next(row for row in rows[begins:] if row[1] == method)
    return float(re.split(r"[, ]", row[2])[0])


@pytest.mark.hardware_data
@pytest.mark.slow
@pytest.mark.skipif(not (DATA / "silverbox").is_dir(), reason="../shared/data is not there")
def test_the_silverbox_has_a_cubic_spring_and_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = silverbox(DATA)
    assert pair is not None
    for peer in ("_pysindy", "_sysidentpy", "_subspace"):
        monkeypatch.setattr(
            f"stillarm.benchmarks.identification.{peer}", lambda pair: (pair.y[pair.test], "")
        )
    ours = compare(pair)[0]
    assert re.fullmatch(
        r"named: cubic_stiffness \(coefficient_per_m2 = 3\.9\d+ \+- [\d.e-]+\)", ours["returned"]
    )
    assert ours["nrmse"] == pytest.approx(told("Silverbox", "ours"), rel=0.05)


@pytest.mark.hardware_data
@pytest.mark.slow
@pytest.mark.skipif(not (DATA / "f16_vibration").is_dir(), reason="../shared/data is not there")
def test_the_aircraft_is_told_as_unexplained_with_its_linear_model() -> None:
    pair = f16(DATA)
    assert pair is not None
    shown, said = as_driven(pair)
    y = pair.y[pair.test]
    assert np.std(shown - y) / np.std(y) == pytest.approx(told("f16_vibration", "ours"), rel=0.05)
    assert said.startswith("unexplained: no cause; linear, with ")


def test_a_folder_without_a_set_is_no_error(tmp_path: Path) -> None:
    assert {name: read(tmp_path) for name, read in SETS.items()} == dict.fromkeys(SETS)
