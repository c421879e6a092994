"""Faults in closed loop, in virtual time: no motion without grounds, never beyond the limits, and recovery
without help.
"""

import pytest

from stillarm.benchmarks.faults.virtual_faults import FAULTS, VirtualFault, run_virtual_fault
from stillarm.common.files.configuration import load_assumed_model, load_configuration
from stillarm.simulation.virtual_time.simulated_recording import default_simulation_configuration

PATH = default_simulation_configuration()
CONFIGURATION = load_configuration(PATH)
MODEL = load_assumed_model(CONFIGURATION, PATH)


@pytest.mark.blind(each_run=6, seed=7)
@pytest.mark.parametrize("kind", [kind for kind, fault in FAULTS.items() if not fault.images])
def test_every_fault_is_stood(kind: str) -> None:
    (verdict,) = run_virtual_fault(kind, CONFIGURATION, MODEL, 1, 7)
    assert verdict.violations == []
    assert verdict.command_max > 0.0
    if FAULTS[kind].groundless:
        assert verdict.reaction_s is not None and verdict.reaction_s <= 0.2


def test_the_campaign_sees_a_controller_that_goes_on_regardless(monkeypatch: pytest.MonkeyPatch) -> None:
    """With all grounds declared missing, the judge must find a violation even for a link that only
    duplicates.
    """
    innocent = FAULTS["link duplicates"]
    guilty = VirtualFault(innocent.begin, innocent.end, shortest_s=0.5, longest_s=0.5, groundless=True)
    monkeypatch.setitem(FAULTS, "guilty", guilty)
    (verdict,) = run_virtual_fault("guilty", CONFIGURATION, MODEL, 1, 7)
    assert any("still commanded" in text for text in verdict.violations)
