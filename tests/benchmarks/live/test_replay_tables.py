"""A replay's tables, read back."""

from pathlib import Path

import numpy as np

from stillarm.benchmarks.live.replay_tables import read_estimates


def test_tables_are_read_back_with_empty_fields_as_nothing(tmp_path: Path) -> None:
    (tmp_path / "estimates.csv").write_text(
        "time_s,method,status,deflection_m,deflection_std_m\n0.0,a,x,,\n0.001,a,x,0.5,0.1\n0.0,b,x,1.0,2.0\n"
    )
    (tmp_path / "frames.csv").write_text(
        "frame,received_s,method,status,delay_s,delay_std_s\n7,0.5,a,estimated,0.07,0.001\n"
    )
    said = read_estimates(tmp_path)
    assert list(said) == ["a", "b"]
    assert np.isnan(said["a"].deflection_m[0]) and said["a"].deflection_std_m[1] == 0.1
    assert said["a"].frame.tolist() == [7] and said["b"].frame.tolist() == []
