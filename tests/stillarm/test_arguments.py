"""Values that no command takes are one line."""

import pytest

from stillarm.main import main
from tests.fixtures.commands import one_line


@pytest.mark.parametrize("seed", ["-1", "1.5", "99999999999999999999999"])
@pytest.mark.parametrize("command", ["simulate", "demo", "rig", "benchmark"])
def test_a_seed_that_no_generator_takes_is_one_line(
    command: str, seed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main([command, "--seed", seed])
    assert stop.value.code == 2
    assert f"{seed}: a whole number from 0 to 9223372036854775807" in one_line(capsys)


@pytest.mark.parametrize("duration", ["nan", "inf", "-1", "0", "x"])
def test_a_duration_that_is_none_is_one_line(duration: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["controller", "--config", "rig.toml", "--duration-s", duration])
    assert stop.value.code == 2
    assert f"{duration}: a number of seconds above 0" in one_line(capsys)
