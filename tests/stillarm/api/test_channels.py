"""`stillarm.load`: arrays with units, frames of either library, and what is not there in one line."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stillarm
from stillarm.api.channels import Table
from stillarm.common.datagrams.fields import unit_of
from stillarm.common.recording.topics import TOPICS


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("acceleration_m_s2", "m/s^2"),
        ("joint_velocity_rad_s", "rad/s"),
        ("deflection_m", "m"),
        ("joint_torque_n_m", "N m"),
        ("displacement_px", "px"),
        ("covariance_xy_px2", "px^2"),
        ("received_s", "s"),
        ("compute_us_p999", "us"),
        ("frame", ""),
        ("status", ""),
    ],
)
def test_the_unit_is_read_from_the_name(name: str, unit: str) -> None:
    assert unit_of(name) == unit


def test_every_number_of_every_topic_has_its_unit() -> None:
    """A field of a new topic that is no count needs a unit in its name."""
    without = {"input", "output", "strain", "features", "inliers", "supervisor_clock_skew"}
    without |= {"added_damping_ratio", "asked_added_damping_ratio"}  # of the critical damping
    for topic in TOPICS:
        if topic.name.endswith("/columns"):  # whatever somebody measured
            continue
        for field, kind in topic.message.__annotations__.items():
            if "float" in str(kind) and field not in without:
                assert unit_of(field), f"{topic.name}: {field}"


@pytest.mark.slow
def test_a_recording_loads_as_arrays_and_frames(short_recording: Path) -> None:
    channels = stillarm.load(short_recording)
    fast = channels.fast
    assert fast.rows == len(fast["time_s"]) > 1000
    assert fast["acceleration_m_s2"].dtype == np.float64
    assert fast.units["acceleration_m_s2"] == "m/s^2"
    assert channels.model.arm.length_m == 2.0
    assert "motor_voltage_v" not in fast  # never measured
    for library in ("pandas", "polars"):
        pytest.importorskip(library)
        frame = channels.frames.frame(library)
        assert list(frame.columns) == list(channels.frames)
        assert frame["received_s"].to_numpy() == pytest.approx(channels.frames["received_s"])
    truth = stillarm.load(short_recording.with_name("truth.mcap"))
    assert "modal_deflections_m" in truth["truth_state"]


def test_what_is_not_there_is_one_line_with_what_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table = Table("fast", {"time_s": np.zeros(2)})
    with pytest.raises(stillarm.UserError, match="no channel 'tme_s'; there are time_s"):
        table["tme_s"]
    with pytest.raises(stillarm.UserError, match="absent"):
        stillarm.load(tmp_path / "absent.mcap")
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "polars", None)
    with pytest.raises(stillarm.UserError, match="pip install pandas"):
        table.frame()


@given(st.integers(1, 5), st.integers(1, 4))
def test_a_channel_of_several_modes_becomes_a_column_for_each(rows: int, modes: int) -> None:
    values = np.arange(rows * modes, dtype=float).reshape(rows, modes)
    flat = Table("t", {"q_m": values})._flat()
    assert np.array_equal(np.column_stack(list(flat.values())), values)
    assert next(iter(flat)) == "q_m_1"


@pytest.mark.slow
def test_the_help_of_the_command_line_looks_for_no_method_and_loads_no_array() -> None:
    """Entry points are read where somebody asks for a method, and not before."""
    code = (
        "import sys\nfrom stillarm.main import main\ntry:\n    main(['--help'])\nexcept SystemExit:\n"
        "    loaded = [n for n in sys.modules if n.endswith('installed_methods') or n in ('numpy', 'cv2')]\n"
        "    print(loaded)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("[]\n")


@pytest.mark.slow
def test_importing_stillarm_loads_nothing_heavy_and_names_all_it_offers() -> None:
    code = (
        "import sys, stillarm; heavy = ('numpy', 'scipy', 'msgspec', 'importlib.metadata');"
        "print([n for n in heavy if n in sys.modules]);"
        "print([n for n in stillarm._FROM if getattr(stillarm, n) is None or n not in dir(stillarm)])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == ["[]", "[]"]
