"""What the fused method assumes: each number once, with unit and origin; used; and to be changed in one place."""

import ast
import re
from dataclasses import FrozenInstanceError, fields, is_dataclass, replace

import numpy as np
import pytest

from stillarm.common.files.configuration import Controller as Settings
from stillarm.controller.estimation.fused.assumptions.assumptions import ASSUMPTIONS, Assumptions
from stillarm.controller.estimation.fused.assumptions.origin import KINDS
from stillarm.controller.estimation.fused.method import FusedMethod
from tests.fixtures.imports import ROOT
from tests.reference.ringing_world import judge, model_for, ring

FUSED = ROOT / "controller" / "estimation" / "fused"
GROUPS = [one.name for one in fields(Assumptions)]
MODULES = sorted(path for path in FUSED.rglob("*.py") if path.parent.name != "assumptions")


@pytest.mark.parametrize("group", GROUPS)
def test_each_assumption_states_its_unit_and_its_origin(group: str) -> None:
    values = getattr(ASSUMPTIONS, group)
    assert is_dataclass(values)
    for one in fields(values):
        unit, origin = one.metadata["unit"], one.metadata["origin"]
        assert unit, f"{group}.{one.name} has no unit"
        assert origin.split(":")[0].split(" ")[0] in KINDS, f"{group}.{one.name}: {origin}"


@pytest.mark.parametrize("group", GROUPS)
def test_each_assumption_is_used(group: str) -> None:
    text = "\n".join(path.read_text() for path in MODULES)
    for one in fields(getattr(ASSUMPTIONS, group)):
        assert re.search(rf"\.{one.name}\b", text), f"{group}.{one.name} is used by no module"


def test_no_module_keeps_a_number_of_its_own() -> None:
    """Numbers at the top of a module are assumptions without unit and origin. Counts of laws and levels are none."""
    for path in MODULES:
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.Assign) and path.name != "laws.py":
                numbers = [one for one in ast.walk(node.value) if _is_number(one)]
                assert not numbers, f"{path.name}: {ast.unparse(node)}"


def _is_number(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


def test_nobody_changes_them_for_another() -> None:
    with pytest.raises(FrozenInstanceError):
        ASSUMPTIONS.start.scale = 0.1  # type: ignore[misc]


def test_one_number_can_be_changed_for_one_method() -> None:
    """A scale of the image that is thought to be known leaves the deflection better known at once."""
    model = model_for(0.006, 0.3)
    surer = replace(ASSUMPTIONS, start=replace(ASSUMPTIONS.start, scale=0.001))
    trial = ring(model, 1, 1.2, delay="constant", excitation="steady", scale_factor=lambda t: 1.03)
    errors = [
        judge(FusedMethod(model, Settings().fused, "model", assumed), model, trial).error[800:]
        for assumed in (ASSUMPTIONS, surer)
    ]
    assert not np.array_equal(errors[0], errors[1])
