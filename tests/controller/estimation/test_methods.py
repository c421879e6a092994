"""The choices of the configuration, and how others are refused."""

from pathlib import Path

import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.common.files.configuration import load_configuration
from stillarm.common.files.model import Arm, Model
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.methods import make_method

CHOICES = {
    ("controller", "reference_shaping"): ("none", "zv", "zvd"),
    ("controller.regression", "form"): ("simplified", "exact"),
    ("controller.damping", "law"): ("velocity", "composite"),
    ("controller.kalman", "fusion_sensor"): ("accelerometer", "strain_gauge"),
    ("controller.kalman", "fusion_delay"): ("timestamps", "model"),
}


@pytest.mark.parametrize(("section", "key"), CHOICES)
def test_each_choice_loads_and_another_is_refused_in_one_line(section: str, key: str, tmp_path: Path) -> None:
    """With the file, the key, and what is allowed."""
    path = tmp_path / "c.toml"
    for choice in CHOICES[section, key]:
        path.write_text(f'[{section}]\n{key} = "{choice}"\n')
        load_configuration(path)
    path.write_text(f'[{section}]\n{key} = "other"\n')
    with pytest.raises(UserError) as error:
        load_configuration(path)
    text = str(error.value)
    assert "\n" not in text
    assert f"{section}.{key}" in text and all(choice in text for choice in CHOICES[section, key])


@pytest.mark.parametrize(
    ("section", "line"),
    [
        ("controller.regression", "frequency_std_fraction = 0.0"),
        ("controller.kalman", "disturbance_m_s2 = 0.0"),
        ("controller.kalman", "imposed_motion_m_s2 = -1.0"),
        ("controller.kalman", "strain_noise_m = 0.0"),
    ],
)
def test_bounds_hold(section: str, line: str, tmp_path: Path) -> None:
    """A number that a filter cannot work with."""
    path = tmp_path / "c.toml"
    path.write_text(f"[{section}]\n{line}\n")
    with pytest.raises(UserError, match=line.split(" ", maxsplit=1)[0]):
        load_configuration(path)


def test_the_paper_and_its_predecessors_go_by_their_names() -> None:
    """And an unknown name, or a model without length, is refused."""
    model = Model(arm=Arm(length_m=2.0))
    for name in (
        "timestamps",
        "correlation",
        "kalman_constant_delay",
        "kalman_variable_delay",
        "kalman_fusion",
    ):
        make_method(name, model, Settings(), "model.toml")
        with pytest.raises(UserError, match=r"model\.toml: arm\.length_m"):
            make_method(name, Model(), Settings(), "model.toml")
    with pytest.raises(UserError, match="nearest: kalman_fusion"):
        make_method("kalman_fusio", model, Settings(), "model.toml")
