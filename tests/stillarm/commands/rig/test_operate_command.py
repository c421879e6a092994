"""`stillarm operate` refuses by itself what the configuration forbids, in one line; the rest is the controller's."""

from math import isnan, nan
from pathlib import Path

import pytest

from stillarm.commands.rig.operate_command import adjust, asked_adjustment
from stillarm.common.files.configuration import Configuration, Link
from stillarm.common.user_error import UserError
from stillarm.main import main
from tests.fixtures.commands import one_line

ROOT = Path(__file__).parents[4]


def test_a_gain_is_a_number_and_a_method_a_name() -> None:
    method, ratio = asked_adjustment("method", "fused")
    assert method == "fused" and isnan(ratio)
    assert asked_adjustment("gain", "0.1") == ("", 0.1)


@pytest.mark.parametrize(
    ("word", "value", "told"),
    [
        ("gain", None, "operate gain: give an added damping ratio"),
        ("gain", "much", "operate gain 'much': give an added damping ratio"),
        ("gain", "inf", "operate gain 'inf': give an added damping ratio"),
        (
            "gain",
            "0.9",
            "added damping ratio 0.9: from 0 to 0.2; controller.adjustable.max_added_damping_ratio",
        ),
        ("method", None, "operate method: name one"),
        (
            "method",
            "kalman",
            "method 'kalman': one of fused, timestamps, correlation; controller.adjustable.methods",
        ),
        ("arm", "now", "operate arm: takes no value; leave out 'now'"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(
    word: str, value: str | None, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["operate", word, *([] if value is None else [value])]
    assert main([*words, "--config", str(ROOT / "configs" / "simulated_rig.toml")]) != 0
    assert told in one_line(capsys)


@pytest.mark.slow
def test_without_a_controller_nothing_is_adjusted() -> None:
    with pytest.raises(UserError, match=r"no controller answers at 127\.0\.0\.1:9"):
        adjust(Configuration(link=Link(reference_port=9)), "", 0.1)
    with pytest.raises(UserError, match="nothing was asked for"):
        adjust(Configuration(), "", nan)
