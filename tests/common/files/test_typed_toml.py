"""TOML into Structs: every refusal is one line with file, key, value and what is allowed."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stillarm.common.files.configuration import Configuration
from stillarm.common.files.model import Model
from stillarm.common.files.scenario import Scenario
from stillarm.common.files.typed_toml import convert_tree, load_toml, parse_toml
from stillarm.common.user_error import UserError

COMMISSIONED = '[commissioned]\ndate = "d"\nrecording = "r"\n[commissioned.std]\n'
REFUSED = [
    (Model, '[camera]\nmode = "free"', ["camera.mode = 'free'", '"freerun" or "triggered"']),
    (Configuration, '[drive]\ndriver = "servo"', ["drive.driver = 'servo'", '"udp_gateway"', '"none"']),
    (
        Configuration,
        "[accelerometer]\nfull_scale_g = 3",
        ["accelerometer.full_scale_g = 3", "use 2 or 4 or 6 or 8 or 16"],
    ),
    (
        Model,
        "[camera]\nframe_rte_hz = 65",
        ["camera.frame_rte_hz = 65", "nearest valid key is camera.frame_rate_hz"],
    ),
    (Model, "camra = 1", ["camra = 1: unknown key", "nearest valid key is camera"]),
    (
        Model,
        "[[arm.modes]]\n[[arm.modes]]\nfrequency_hz = -1.0",
        ["arm.modes[1].frequency_hz = -1.0", ">= 0.01"],
    ),
    (Model, "[[arm.modes]]\nfrequenzy_hz = 1", ["arm.modes[0].frequenzy_hz", "arm.modes[0].frequency_hz"]),
    (Model, "[arm]\nmodes = []", ["arm.modes = []", "length >= 1"]),
    (Model, '[camera]\nframe_rate_hz = "65"', ["camera.frame_rate_hz = '65'", "expected `float`, got `str`"]),
    (Model, "camera = 3", ["camera = 3", "expected `object`"]),
    (Model, "[timing]\ncycle_s = nan", ["timing.cycle_s = nan", "finite"]),
    (Model, "[[arm.modes]]\nparticipation = -inf", ["arm.modes[0].participation = -inf", "finite"]),
    (Model, '[[effects]]\ncause = "a"\n[[effects]]\nx = [1]', ["effects[1].x = [1]", "got `array`"]),
    (Configuration, "[link]\ncontroller_port = 70000", ["link.controller_port = 70000", "<= 65535"]),
    (Configuration, "[controller.regression]\nframes = 2.5", ["controller.regression.frames = 2.5", "`int`"]),
    (
        Configuration,
        "[supervisor.tracker]\nfeature = 9",
        ["supervisor.tracker.feature", "supervisor.tracker.features"],
    ),
    (Scenario, "[[strikes]]\ntime_s = 1.0", ["strikes[0].deflection_m", "missing"]),
    (
        Model,
        f'{COMMISSIONED}"camera.noise_std_px" = 0.1\n"arm.length_m" = -1.0',
        ['commissioned.std."arm.length_m" = -1.0', ">= 0"],
    ),
    (Model, f'{COMMISSIONED}first = 0.1\nsecond = "two"', ["commissioned.std.second = 'two'", "`float`"]),
    (Model, f'{COMMISSIONED}"arm.length_m" = nan', ['commissioned.std."arm.length_m" = nan', "finite"]),
    (Model, '[[effects]]\ncause = "a"\nx = 1.0\ny = [1]', ["effects[0].y = [1]", "got `array`"]),
    (Model, "a = \n", ["not valid TOML"]),
    (Model, "a = " + "[" * 5000, ["not valid TOML"]),
]


@pytest.mark.parametrize(("structure", "text", "expected"), REFUSED)
def test_refusals_name_file_key_value_and_bound(structure: Any, text: str, expected: list[str]) -> None:
    with pytest.raises(UserError) as refused:
        parse_toml(text, structure, "rig.toml")
    message = str(refused.value)
    assert message.startswith("rig.toml: ") and "\n" not in message
    for part in expected:
        assert part in message


def test_a_long_value_is_shortened() -> None:
    with pytest.raises(UserError) as refused:
        parse_toml(f'[camera]\nmode = "{"x" * 500}"', Model, "rig.toml")
    assert len(str(refused.value)) < 200 and "..." in str(refused.value)


def test_a_byte_order_mark_is_no_part_of_the_first_key(tmp_path: Path) -> None:
    """Some editors write one; a recording holds the file's text as it was, so the text may begin with it, too."""
    text = "\ufeff[arm]\nlength_m = 3.0\n"
    (tmp_path / "m.toml").write_text(text, encoding="utf-8")
    assert load_toml(tmp_path / "m.toml", Model).arm.length_m == 3.0
    assert parse_toml(text, Model, "m.toml").arm.length_m == 3.0


@pytest.mark.parametrize(
    ("content", "expected"), [(None, "cannot be read"), (b"a = '\xff'", "not UTF-8 text at byte 5")]
)
def test_files_that_cannot_be_read(tmp_path: Path, content: bytes | None, expected: str) -> None:
    path = tmp_path / "m.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(UserError, match=expected):
        load_toml(path, Model)
    with pytest.raises(UserError, match="cannot be read"):
        load_toml(tmp_path, Model)


_keys = st.sampled_from(
    ["arm", "modes", "camera", "mode", "effects", "cause", "frequency_hz", "x", "a.b", "[...]", ""]
)
_values = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
_trees = st.recursive(
    _values, lambda t: st.lists(t, max_size=3) | st.dictionaries(_keys, t, max_size=3), max_leaves=12
)


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(st.dictionaries(_keys, _trees, max_size=4))
def test_any_tree_is_read_or_refused_in_one_line(tree: dict[str, Any]) -> None:
    try:
        convert_tree(tree, Model, "any.toml")
    except UserError as error:
        assert str(error).startswith("any.toml: ") and "\n" not in str(error)


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=60))
def test_any_text_is_read_or_refused_in_one_line(text: str) -> None:
    try:
        parse_toml(text, Model, "any.toml")
    except UserError as error:
        assert "\n" not in str(error)
