"""The configuration file and the files that it names."""

from pathlib import Path

import pytest

from stillarm.common.files.configuration import (
    default_configuration_path,
    is_simulated_rig,
    load_assumed_model,
    load_configuration,
    load_true_model,
    model_path,
)
from stillarm.common.user_error import UserError


def test_the_default_configuration_loads_with_its_model() -> None:
    path = default_configuration_path()
    configuration = load_configuration(path)
    assert load_assumed_model(configuration, path).arm.length_m == 2.0
    assert load_true_model(configuration, path) == load_assumed_model(configuration, path)


def test_only_the_simulated_rig_is_one() -> None:
    """This decides whether only an identified model may damp."""
    path = default_configuration_path()
    assert not is_simulated_rig(load_configuration(path))
    assert is_simulated_rig(load_configuration(path.with_name("simulated_rig.toml")))


def test_every_configuration_that_comes_with_the_program_loads() -> None:
    for path in default_configuration_path().parent.glob("*.toml"):
        if not path.stem.startswith(("model", "scenario")):
            configuration = load_configuration(path)
            load_assumed_model(configuration, path)
            load_true_model(configuration, path)


def test_models_are_found_beside_the_configuration(tmp_path: Path) -> None:
    (tmp_path / "c.toml").write_text('model = "a.toml"\n[rig]\nmodel = "b.toml"\n')
    (tmp_path / "a.toml").write_text("[arm]\nlength_m = 1.0")
    (tmp_path / "b.toml").write_text("[arm]\nlength_m = 2.0")
    path = tmp_path / "c.toml"
    configuration = load_configuration(path)
    assert model_path(configuration, path) == tmp_path / "a.toml"
    assert load_assumed_model(configuration, path).arm.length_m == 1.0
    assert load_true_model(configuration, path).arm.length_m == 2.0


def test_both_processes_at_one_address_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "c.toml"
    path.write_text("[link]\nsupervisor_port = 47001\n")
    with pytest.raises(UserError, match=r"c\.toml: link\.supervisor_port = 47001"):
        load_configuration(path)
    path.write_text('[link]\nsupervisor_port = 47001\nsupervisor_host = "10.0.0.2"\n')
    assert load_configuration(path).link.supervisor_host == "10.0.0.2"


def test_a_model_that_is_not_there_is_named(tmp_path: Path) -> None:
    path = tmp_path / "c.toml"
    path.write_text('model = "none.toml"')
    with pytest.raises(UserError, match=r"none\.toml: cannot be read"):
        load_assumed_model(load_configuration(path), path)


def test_files_are_found_beside_the_configuration_wherever_the_program_was_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Names of scenarios that come with the program, and cameras that are no files, stay as they are."""
    folder = tmp_path / "rig"
    folder.mkdir()
    path = folder / "c.toml"
    path.write_text(
        '[controller]\nschedule = "s.toml"\n[rig]\nscenario = "demo"\n[link]\nkey_file = "key"\n'
        '[camera]\ndriver = "file"\ndevice = "v.avi"\n'
    )
    monkeypatch.chdir(tmp_path)
    read = load_configuration(Path("rig/c.toml"))
    assert read.controller.schedule == "rig/s.toml" and read.rig.scenario == "demo"
    assert (read.link.key_file, read.camera.device) == ("rig/key", "rig/v.avi")
    path.write_text(f'[rig]\nscenario = "{tmp_path}/s.toml"\n[camera]\ndevice = "0"\n')
    read = load_configuration(Path("rig/c.toml"))
    assert (read.rig.scenario, read.camera.device) == (f"{tmp_path}/s.toml", "0")
    assert (read.controller.schedule, read.link.key_file) == ("", "")
