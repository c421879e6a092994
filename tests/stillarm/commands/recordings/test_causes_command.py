"""`stillarm causes`."""

import json

import pytest

from stillarm.causes_page import ALL_CAUSES, schema, section
from stillarm.main import main


def test_the_command_prints_a_list_one_cause_or_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["causes"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(ALL_CAUSES)
    for name in ("gear_backlash", "joint_coulomb_friction"):
        assert main(["causes", name]) == 0
        assert capsys.readouterr().out == section(ALL_CAUSES[name])
    assert main(["causes", "--schema"]) == 0
    assert json.loads(capsys.readouterr().out) == schema()
    assert main(["causes", "gear_backslash"]) == 1
    assert "the nearest is gear_backlash" in capsys.readouterr().err
