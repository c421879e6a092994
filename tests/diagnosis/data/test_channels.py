"""Which channels there are, and that nothing in the diagnosis takes one for granted."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stillarm import diagnosis
from stillarm.diagnosis.data.channels import FAST_CHANNELS, FRAME_CHANNELS, without_dead_sensors
from stillarm.diagnosis.data.split import interleaved
from stillarm.diagnosis.fitting.fit import fit
from stillarm.diagnosis.fitting.fitted import make_data
from stillarm.diagnosis.physics.world import World
from stillarm.diagnosis.sensors.image_dating import image_nats, older_from
from tests.fixtures.synthetic import MODEL, measured

HOLDERS = {"channels", "sigma", "residuals", "colour", "blocks", "train", "held"}
"""Tables by channel, of which a literal subscript would be a KeyError where the channel is not there."""


def _literal_lookups(path: Path) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if not (isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load)):
            continue
        holder = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
        literal = node.slice.value if isinstance(node.slice, ast.Constant) else None
        if holder in HOLDERS and literal in (*FAST_CHANNELS, *FRAME_CHANNELS):
            found.append(f"{path.name}:{node.lineno}: {holder}[{literal!r}]")
    return found


@pytest.mark.slow
def test_no_channel_is_taken_for_granted() -> None:
    folder = Path(next(iter(diagnosis.__path__)))
    assert not [line for path in sorted(folder.rglob("*.py")) for line in _literal_lookups(path)]


def test_the_search_for_such_lookups_finds_one(tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text("x = fit.sigma['displacement'] + world.channels[name]\n")
    assert _literal_lookups(tmp_path / "bad.py") == ["bad.py:1: sigma['displacement']"]


def test_a_fit_answers_none_for_a_channel_that_is_not_there() -> None:
    data = measured(6.0, 3)
    bare = replace(data, frames=replace(data.frames, displacement_px=np.full(len(data.frames), np.nan)))
    world = World(bare, MODEL)
    one = fit(make_data(world, interleaved(6.0)), world.space.vector(), (), iterations=0)
    assert one.channel("displacement") is None
    assert image_nats(one) == 0.0 and older_from(one) is None
    sensor = one.channel("acceleration")
    assert sensor is not None and sensor.off.shape == sensor.measured.shape


@pytest.mark.parametrize("name", ["acceleration", "deflection"])
def test_a_dead_sensor_is_left_out_and_told(name: str) -> None:
    data = measured(6.0, 3)
    alive, dead = without_dead_sensors(replace(data, **{name: np.full(data.cycles, 0.25)}))
    assert name not in World(alive, MODEL).channels
    assert dead == {name: f"each of its {data.cycles} values is 0.25"}
    assert without_dead_sensors(data) == (data, {})


def test_a_joint_that_stands_still_is_known() -> None:
    data = measured(6.0, 3)
    alive, dead = without_dead_sensors(replace(data, position=np.zeros(data.cycles)))
    assert not dead and "joint_position" in World(alive, MODEL).channels
