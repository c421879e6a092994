"""Lines of the log: one JSON object each."""

import json

import pytest

from stillarm.common.files.configuration import Configuration
from stillarm.common.recorder.structured_log import log, log_line, log_start


def test_a_line_is_one_json_object_whatever_is_in_it() -> None:
    line = log_line("controller", "warning", "two\nlines", 0.5, value=float("nan"), nested={"a": [1, "ü"]})
    assert "\n" not in line
    assert json.loads(line) == {
        "time": "1970-01-01T00:00:00.500+00:00",
        "level": "warning",
        "process": "controller",
        "event": "two\nlines",
        "value": None,
        "nested": {"a": [1, "ü"]},
    }


def test_the_configuration_is_in_the_first_line(capsys: pytest.CaptureFixture[str]) -> None:
    log_start("controller", Configuration(), "a.toml")
    log("controller", "error", "x")
    first, warning, second = capsys.readouterr().err.splitlines()
    assert "demo key" in json.loads(warning)["event"]
    assert json.loads(first)["configuration"]["link"]["controller_port"] == 47001
    assert json.loads(second)["level"] == "error"
