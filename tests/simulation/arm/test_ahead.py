"""What is compiled before any clock runs, and what the user is told meanwhile."""

import io
import subprocess
import sys
import time

import pytest

from stillarm.common.user_error import UserError
from stillarm.simulation.arm.ahead import ready_plant, told_if_slow
from tests.reference.plant_judge import FIRST, SECOND, model

_LIVE = """
from stillarm.simulation.arm import compiled_laws, joint, stepper
from stillarm.simulation.arm.ahead import ready_plant
from tests.reference.plant_judge import FIRST, SECOND, model

def compiled():
    return {
        f"{module.__name__}.{name}": len(function.signatures)
        for module in (compiled_laws, joint, stepper)
        for name, function in vars(module).items()
        if hasattr(function, "signatures")
    }

plant = ready_plant(model([FIRST, SECOND]))
ready = compiled()
plant.strike(2, 0.001)
plant.modal_forces_m_s2 = [0.1, 0.2]
plant.tip_acceleration_m_s2
plant.advance(0.1)
plant.strike(1, 0.001)
print({name for name, count in compiled().items() if count != ready[name]} or "nothing")
"""


@pytest.mark.slow
def test_a_ready_plant_compiles_nothing_when_it_is_struck_pushed_or_moved() -> None:
    """A process of its own: here, other tests have compiled all. An impact used to compile for 50 ms as it fell."""
    said = subprocess.run([sys.executable, "-c", _LIVE], check=True, capture_output=True, text=True)
    assert said.stdout.strip() == "nothing"


def test_a_model_that_cannot_be_simulated_is_refused_by_its_name() -> None:
    with pytest.raises(UserError, match=r"mine\.toml"):
        ready_plant(model([FIRST, SECOND]).__class__(), "mine.toml")


def test_one_line_tells_what_takes_long_and_how_long_it_took() -> None:
    told = io.StringIO()
    with told_if_slow("compiling", told, within_s=0.01):
        deadline = time.monotonic() + 5.0
        while not told.getvalue() and time.monotonic() < deadline:
            time.sleep(0.005)
        assert told.getvalue() == "compiling: "
    assert told.getvalue() == "compiling: 0 s\n"


def test_nothing_is_told_of_what_is_quick() -> None:
    told = io.StringIO()
    with told_if_slow("compiling", told, within_s=60.0):
        pass
    assert told.getvalue() == ""


def test_the_line_ends_where_it_fails() -> None:
    told = io.StringIO()
    with pytest.raises(UserError), told_if_slow("compiling", told, within_s=0.0):
        deadline = time.monotonic() + 5.0
        while not told.getvalue() and time.monotonic() < deadline:
            time.sleep(0.005)
        raise UserError("no")
    assert told.getvalue().endswith(" s\n")
