"""The comparison with peers: all judged by one error; a peer that is absent, or runs away, is a row that says so."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.benchmarks import identification
from stillarm.benchmarks.identification import compare, run_all, simulation_speed
from stillarm.benchmarks.identification_data import Pair, silverbox
from stillarm.common.user_error import UserError


def _pair() -> Pair:
    n = 600
    return Pair(
        "made up", Path(), {}, np.zeros(n), np.sin(np.arange(n) / 9.0), 100.0, slice(300, n), slice(0, 300)
    )


def test_each_method_is_a_row_and_what_runs_away_has_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(pair: Pair) -> tuple[np.ndarray, str]:
        raise ModuleNotFoundError("no", name="pysindy")

    monkeypatch.setattr(identification, "_ours", lambda pair: (0.9 * pair.y[pair.test], "named: x"))
    monkeypatch.setattr(identification, "_subspace", lambda pair: (pair.y[pair.test], "linear"))
    monkeypatch.setattr(identification, "_pysindy", absent)
    monkeypatch.setattr(identification, "_sysidentpy", lambda pair: (np.full(300, np.nan), "9 terms"))
    ours, subspace, sindy, narx = compare(_pair())
    assert ours["nrmse"] == pytest.approx(0.1, rel=0.02) and subspace["nrmse"] == 0.0
    assert (sindy["nrmse"], narx["nrmse"]) == (None, None)
    assert "pip install stillarm[peers]" in sindy["returned"]
    assert "diverges" in narx["returned"]


def test_the_simulation_agrees_with_scipys_and_outruns_it() -> None:
    speed = simulation_speed()
    assert speed["largest_difference"] < 1e-3
    assert speed["times_real_time"] > 0.0


def test_data_that_are_not_there_are_told_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(identification, "simulation_speed", dict)
    assert silverbox(tmp_path) is None
    assert run_all(None) == {"rows": [], "simulation": {}}
    with pytest.raises(UserError, match="contains none of silverbox"):
        run_all(tmp_path)
