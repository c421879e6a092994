"""A simulation after `compile_ahead` compiles nothing more, whatever acts in it; nor does a search for lost frames."""

import numpy as np
import pytest
from msgspec.structs import replace

from stillarm.common.causes import CAUSES
from stillarm.common.files.model import Mode
from stillarm.diagnosis.data import lost_frames
from stillarm.diagnosis.physics.ahead import compile_ahead
from stillarm.diagnosis.physics.camera import expose
from stillarm.diagnosis.physics.linear_modes import add_decay, free_decay, tip_of
from stillarm.diagnosis.physics.velocity_loop import equivalent_command
from stillarm.diagnosis.physics.world import World
from stillarm.simulation.arm.compiled_laws import address_of
from stillarm.simulation.arm.free_run import free_run
from tests.fixtures.synthetic import MODEL, empty

KERNELS = (free_run, tip_of, free_decay, add_decay, expose, equivalent_command)


def compiled() -> list[int]:
    """How many signatures each of the kernels is compiled for, and how many laws have an address."""
    return [*(len(one.signatures) for one in KERNELS), address_of.cache_info().currsize]  # type: ignore[attr-defined]


@pytest.mark.parametrize("modes", [1, 2])
def test_nothing_is_left_to_compile(modes: int) -> None:
    compile_ahead()
    before = compiled()
    both = [Mode(), Mode(frequency_hz=15.0, participation=-0.2)]
    model = replace(MODEL, arm=replace(MODEL.arm, modes=both[:modes]))
    world = World(empty(6.0, model), model, (3000,))
    vector = world.space.vector()
    near = world.predict(vector)
    for values in (
        {"jump.1.0.v": 0.01},
        {"drive.further_lag_s": 0.01},
        {"drive.gap_rad": 0.004},
        {"camera.offset_px": 1.0},
    ):
        world.predict(world.space.with_values(vector, values), near)
    assert compiled() == before


def test_the_search_for_lost_frames_is_compiled() -> None:
    compile_ahead()
    kernel = lost_frames._likeliest
    before = len(kernel.signatures)
    assert before > 0
    received_s = np.delete(np.arange(60.0) / 30.0, 20)
    assert lost_frames.lost_before(received_s, np.ones(58, np.int64), 1.0 / 30.0).sum() == 1
    assert len(kernel.signatures) == before


def test_every_law_of_the_stepper_has_its_address() -> None:
    compile_ahead()
    laws = [
        one
        for one in CAUSES.values()
        if one.law and one.acts in ("force", "friction", "frequency", "command")
    ]
    assert laws and address_of.cache_info().currsize >= len(laws)
