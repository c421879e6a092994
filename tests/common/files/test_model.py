"""The model file: defaults, and what spans several keys."""

import math
from pathlib import Path

import msgspec
import pytest

from stillarm.common.files.configuration import default_configuration_path
from stillarm.common.files.model import Mode, Model, length_of, load_model
from stillarm.common.user_error import UserError


def model(folder: Path, text: str) -> Model:
    path = folder / "m.toml"
    path.write_text(text)
    return load_model(path)


def test_an_empty_file_takes_every_default(tmp_path: Path) -> None:
    assert model(tmp_path, "") == Model()
    assert Model().arm.modes == [Mode()] and Model().arm.length_m is None


def test_the_model_that_comes_with_the_program_is_the_contract_s() -> None:
    shipped = load_model(default_configuration_path().parent / "model.toml")
    assert shipped.arm.length_m == 2.0
    assert (shipped.drive, shipped.camera, shipped.timing) == (Model().drive, Model().camera, Model().timing)


def test_angular_frequency() -> None:
    assert math.isclose(Mode(frequency_hz=2.6).angular_frequency, 16.336281798666924, rel_tol=1e-15)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[camera]\nscale_px_per_m = 1e-300", "camera.scale_px_per_m = 1e-300: .* at least 1e-06"),
        ("[[arm.modes]]\nparticipation = 0.0", r"arm.modes\[0\].participation = 0"),
        ("[[arm.modes]]\nfrequency_hz = 1e-300", r"arm.modes\[0\].frequency_hz = 1e-300: .*0.01"),
        ("[accelerometer]\nbias_m_s2 = 1e300", "accelerometer.bias_m_s2 = 1e\\+300: .*1000000000"),
        ("[timing]\ncycle_s = 1e-9", "timing.cycle_s = 1e-09: .*0.0001"),
        ("[drive]\nmin_position_rad = 1.0", "drive.min_position_rad = 1.0: must lie below"),
        ("[accelerometer]\nscale = 0.0", "accelerometer.scale = 0"),
        ("[camera]\nscale_px_per_m = -0.0", "camera.scale_px_per_m = 0"),
        ("[camera]\nexposure_s = 0.02", "camera.exposure_s = 0.02: longer than a frame"),
        ("[[effects]]\nx = 1", r"effects\[0\].cause"),
        ("[[effects]]\ncause = 1", r"effects\[0\].cause"),
    ],
)
def test_contradictions_are_one_line(tmp_path: Path, text: str, expected: str) -> None:
    with pytest.raises(UserError, match=expected) as refused:
        model(tmp_path, text)
    assert "\n" not in str(refused.value) and "m.toml" in str(refused.value)


def test_signed_scales_and_a_full_frame_s_exposure_are_allowed(tmp_path: Path) -> None:
    read = model(
        tmp_path,
        "[accelerometer]\nscale = -1.0\n[camera]\nscale_px_per_m = -800.0\nexposure_s = 0.01\nframe_rate_hz = 100.0\n"
        '[[effects]]\ncause = "cubic_stiffness"\ncoefficient_per_m2 = 1000.0\n',
    )
    assert read.accelerometer.scale == -1.0 and read.effects[0]["coefficient_per_m2"] == 1000.0


def test_a_length_that_is_needed_is_asked_for(tmp_path: Path) -> None:
    assert length_of(model(tmp_path, "[arm]\nlength_m = 1.5"), "m.toml") == 1.5
    with pytest.raises(UserError, match=r"m\.toml: arm\.length_m.*calibrate"):
        length_of(Model(), "m.toml")


def test_the_mark_of_commissioning_is_read_kept_and_left_out_where_there_is_none(tmp_path: Path) -> None:
    read = model(
        tmp_path,
        '[commissioned]\ndate = "2026-01-31"\nrecording = "r.mcap"\n'
        '[commissioned.std]\n"arm.modes[0].frequency_hz" = 0.001\n',
    )
    assert read.identified and not Model().identified
    assert read.commissioned.std == {"arm.modes[0].frequency_hz": 0.001}  # type: ignore[union-attr]
    assert "commissioned" not in msgspec.to_builtins(Model())
    assert msgspec.to_builtins(read)["commissioned"]["recording"] == "r.mcap"


def test_a_mark_without_a_recording_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"commissioned\.recording: required key is missing"):
        model(tmp_path, '[commissioned]\ndate = "2026-01-31"\n')
