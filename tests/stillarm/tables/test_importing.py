"""A description is obeyed: values in the role's unit, unknown scales left alone, the description kept."""

from pathlib import Path

import numpy as np
import pytest

from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.tables.description import NOTE_NAME, parse_description
from stillarm.tables.importing import ImportedTables, import_tables
from stillarm.tables.table import Table, TableFile
from stillarm.tables.unscaled import unscaled_channels

DEGREE = np.pi / 180.0
COLUMNS = {
    "t": 1_700_000_000_000_000_000 + 2_000_000 * np.arange(50),
    "theta": np.linspace(-90.0, 90.0, 50),
    "gauge": np.arange(50.0),
    "mystery": np.arange(50.0) ** 2,
    "px": np.linspace(0.0, 5.0, 50),
}
FILE = TableFile("rig.csv", "csv", (Table("", COLUMNS),))
TIMED = """source = "rig.csv"
[[tables]]
time_column = "t"
time_unit = "ns"
time_zero = 1700000000000000000
"""


def channel(column: str, role: str, **keys: object) -> str:
    lines = [f'[[tables.channels]]\ncolumn = "{column}"\nrole = "{role}"']
    lines += [
        f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value}" for key, value in keys.items()
    ]
    return "\n".join(lines) + "\n"


def imported(tmp_path: Path, text: str, file: TableFile = FILE) -> tuple[ImportedTables, Path]:
    out = tmp_path / "rec.mcap"
    return import_tables(file, parse_description(text, "d.toml"), text, out), out


def test_units_scales_and_offsets(tmp_path: Path) -> None:
    text = (
        TIMED
        + channel("theta", "joint_position_rad", unit="deg")
        + channel("gauge", "deflection_m", scale=-0.001, offset=0.5)
    )
    _, out = imported(tmp_path, text)
    fast = open_recording(out).columns("/fast")
    np.testing.assert_allclose(fast["joint_position_rad"], COLUMNS["theta"] * DEGREE, rtol=1e-15)
    np.testing.assert_allclose(fast["deflection_m"], 0.5 - 0.001 * COLUMNS["gauge"], rtol=1e-15)
    np.testing.assert_allclose(fast["time_s"], 0.002 * np.arange(50), atol=1e-12)
    assert fast["cycle"].tolist() == list(range(0, 100, 2))


def test_an_unknown_scale_never_gets_into_a_column_with_a_unit(tmp_path: Path) -> None:
    text = (
        TIMED
        + channel("gauge", "deflection_m", unit="unknown")
        + channel("theta", "joint_position_rad", unit="deg")
    )
    report, out = imported(tmp_path, text)
    recording = open_recording(out)
    assert np.isnan(recording.columns("/fast")["deflection_m"]).all()
    assert report.unscaled == ("gauge (deflection_m)",)
    (found,) = unscaled_channels(recording)
    assert (found.role, found.name) == ("deflection_m", "gauge")
    np.testing.assert_array_equal(found.values, COLUMNS["gauge"])
    np.testing.assert_allclose(found.time_s, 0.002 * np.arange(50), atol=1e-12)


def test_strain_has_a_column_of_its_own_in_any_unit(tmp_path: Path) -> None:
    _, out = imported(tmp_path, TIMED + channel("gauge", "strain"))
    np.testing.assert_array_equal(open_recording(out).columns("/fast")["strain"], COLUMNS["gauge"])


def test_the_description_is_kept(tmp_path: Path) -> None:
    text = TIMED + channel("gauge", "strain")
    _, out = imported(tmp_path, text)
    assert open_recording(out).header.notes[NOTE_NAME] == text


def test_what_has_no_role_is_kept_by_name(tmp_path: Path) -> None:
    text = TIMED + channel("mystery", "unknown") + channel("gauge", "ignore")
    _, out = imported(tmp_path, text)
    rows = open_recording(out).columns("/fast/columns")["columns"]
    assert rows[3] == {"mystery": 9.0}


def test_a_pair_goes_where_diagnose_takes_it(tmp_path: Path) -> None:
    text = (
        'source = ""\n[[tables]]\nrate_hz = 100.0\n' + channel("theta", "input") + channel("gauge", "output")
    )
    _, out = imported(tmp_path, text)
    recording = open_recording(out)
    pair, notes = recording.columns("/pair"), recording.header.notes
    assert (notes["rate_hz"], notes["input_column"], notes["output_column"]) == ("100.0", "theta", "gauge")
    np.testing.assert_array_equal(pair["output"], COLUMNS["gauge"])
    assert pair["time_s"][1] == 0.01


def test_an_unknown_rate_counts_samples_and_says_so(tmp_path: Path) -> None:
    text = 'source = ""\n[[tables]]\nrate_hz = "unknown"\n' + channel("gauge", "strain")
    report, out = imported(tmp_path, text)
    assert any("rate unknown" in note for note in report.notes)
    assert open_recording(out).columns("/fast")["time_s"].tolist() == list(range(50))


def test_images_become_frames(tmp_path: Path) -> None:
    _, out = imported(tmp_path, TIMED + channel("px", "displacement_px"))
    frames = open_recording(out).columns("/frames")
    np.testing.assert_array_equal(frames["displacement_px"], COLUMNS["px"])
    assert frames["frame"].tolist() == list(range(50)) and set(frames["status"]) == {0}


def test_what_has_no_role_stays_beside_the_images(tmp_path: Path) -> None:
    report, out = imported(tmp_path, TIMED + channel("px", "displacement_px") + channel("gauge", "unknown"))
    assert report.rows == {"/frames": 50, "/frames/columns": 50}
    assert open_recording(out).columns("/frames/columns")["columns"][7] == {"gauge": 7.0}


def test_images_of_unknown_scale_are_not_taken_for_px(tmp_path: Path) -> None:
    text = TIMED + channel("px", "displacement_px", unit="unknown") + channel("gauge", "frame")
    _, out = imported(tmp_path, text)
    recording = open_recording(out)
    assert np.isnan(recording.columns("/frames")["displacement_px"]).all()
    (found,) = unscaled_channels(recording)
    np.testing.assert_array_equal(found.values, COLUMNS["px"])


def test_tables_of_other_times_are_sorted_into_each_other(tmp_path: Path) -> None:
    file = TableFile(
        "rig.mcap",
        "mcap",
        (
            Table("/a", {"t": np.array([0.0, 0.1, 0.2]), "x": np.array([1.0, 2.0, 3.0])}),
            Table("/b", {"t": np.array([0.05, 0.15]), "y": np.array([5.0, np.nan])}),
        ),
    )
    text = 'source = ""\n[[tables]]\nname = "/a"\ntime_column = "t"\n' + channel(
        "x", "motor_current_a", unit="A"
    )
    text += '[[tables]]\nname = "/b"\ntime_column = "t"\n' + channel("y", "motor_voltage_v", unit="mV")
    _, out = imported(tmp_path, text, file)
    fast = open_recording(out).columns("/fast")
    assert fast["time_s"].tolist() == [0.0, 0.05, 0.1, 0.15, 0.2]
    np.testing.assert_array_equal(fast["motor_current_a"], [1.0, np.nan, 2.0, np.nan, 3.0])
    assert fast["motor_voltage_v"][1] == 0.005


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (TIMED + channel("theta", "joint_positon_rad"), "the nearest is joint_position_rad"),
        (TIMED + channel("theta", "joint_position_rad", unit="furlong"), "not known; give scale"),
        (
            TIMED + channel("theta", "joint_position_rad", unit="A"),
            "does not fit role joint_position_rad; use one of",
        ),
        (TIMED + channel("theta", "joint_position_rad", scale=0.0), "other than 0"),
        (TIMED + channel("absent", "strain"), "column 'absent': not there; it holds t, theta"),
        (
            TIMED + channel("theta", "strain") + channel("gauge", "strain"),
            "two channels have the role strain",
        ),
        (TIMED + channel("theta", "input"), "role input needs one channel with role output"),
        (
            '[[tables]]\ntime_column = "when"\n' + channel("gauge", "strain"),
            "time_column = 'when': no such column",
        ),
        ("[[tables]]\n" + channel("gauge", "strain"), "no time_column and no rate_hz"),
        ('[[tables]]\nname = "other"\nrate_hz = 1.0\n' + channel("gauge", "strain"), "no table 'other'"),
        ('[[tables]]\ntime_column = "t"\n' + channel("gauge", "strain"), "correct time_unit"),
        (TIMED, "gives no channel a role"),
        ('source = "x"\n', "--look"),
        ("[[tables]]\nrate = 3\n", "unknown key; the nearest valid key is"),
        (TIMED + channel("t", "joint_position_rad", unit="rad"), "at most 1e+15 is a measurement"),
    ],
)
def test_mistakes_give_one_line_that_helps(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(UserError) as refused:
        imported(tmp_path, text)
    assert says in str(refused.value) and "\n" not in str(refused.value)
