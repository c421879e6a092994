"""The numbers and the file of an identification."""

from pathlib import Path

import pytest

from stillarm.common.files.model import Model, load_model
from stillarm.common.user_error import UserError
from stillarm.found_model import print_parameters, write_model


def test_a_parameter_is_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    print_parameters({"drive.bandwidth_hz": (12.3456789, 0.0123), "arm.length_m": (1.0, 0.0)})
    first, second = capsys.readouterr().out.splitlines()
    assert first.split() == ["drive.bandwidth_hz", "12.3457", "+-", "0.012"]
    assert second.split() == ["arm.length_m", "1", "+-", "0"]


def test_the_file_loads_as_the_model(tmp_path: Path) -> None:
    write_model(Model(), tmp_path / "found.toml")
    assert load_model(tmp_path / "found.toml") == Model()


def test_where_it_cannot_be_written_is_one_line_that_tells_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "absent" / "found.toml"
    with pytest.raises(UserError) as error:
        write_model(Model(), path)
    said = str(error.value)
    assert said.startswith(f"{path}: cannot be written (") and said.endswith("name another file with -o")
    assert "\n" not in said
