"""What a machine needs."""

from stillarm.preflight.machine import MachineFacts, judge_machine
from stillarm.preflight.verdict import Level


def test_an_ordinary_machine_may_run_a_simulated_rig() -> None:
    facts = MachineFacts(("no FIFO",), "6.1", False, frozenset({"powersave"}), 1)
    levels = [v.level for v in judge_machine(facts, emulated=True)]
    assert levels == [Level.WARN] * 4
    assert judge_machine(facts, emulated=False)[0].level == Level.FAIL
