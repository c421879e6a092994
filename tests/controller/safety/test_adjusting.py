"""What an operator may adjust: in which states, within which bounds; in closed loop without a step of the command."""

from math import inf, nan

import msgspec
import numpy as np
import pytest

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.files.configuration import Adjustable, Damping
from stillarm.common.files.configuration import Controller as Settings
from stillarm.controller.input.cycle_input import CycleInput
from stillarm.controller.loop.recorded import adjustments, settings_sample
from stillarm.controller.loop.step import Controller
from stillarm.controller.safety.adjusting import Adjusting, adjustment_refusal, offered_methods
from stillarm.controller.safety.table import MAY_ADJUST, MOVING, Setting, State
from tests.fixtures.safety_loop import MODEL, SETTINGS, A, run, states

GAIN, METHOD = Adjustment("", 0.05), Adjustment("timestamps", nan)


def test_a_method_never_changes_while_the_joint_may_be_damped_by_it() -> None:
    assert {state for setting, state in MAY_ADJUST if setting is Setting.METHOD} & MOVING == {State.ARMED}
    assert (Setting.GAIN, State.DAMPING) in MAY_ADJUST
    assert not [setting for setting, state in MAY_ADJUST if state is State.DEGRADED]


@pytest.mark.parametrize("state", list(State))
def test_a_refusal_by_the_state_names_it_and_what_to_do(state: State) -> None:
    for setting, asked in ((Setting.GAIN, GAIN), (Setting.METHOD, METHOD)):
        why = adjustment_refusal(asked, Settings(), state)
        assert (why == "") == ((setting, state) in MAY_ADJUST)
        assert why == "" or (f"the state is {state}; " in why and str(setting) in why)
    assert adjustment_refusal(METHOD, Settings(), None) == ""


@pytest.mark.parametrize("ratio", [-0.01, 0.2001, inf, -inf])
def test_a_gain_beyond_its_bounds_is_refused_with_the_key(ratio: float) -> None:
    why = adjustment_refusal(Adjustment("", ratio), Settings(), State.IDLE)
    assert "from 0 to 0.2; controller.adjustable.max_added_damping_ratio" in why


def test_the_configured_gain_and_method_are_always_within_the_bounds() -> None:
    settings = Settings(
        method="kalman_fusion",
        damping=Damping(added_damping_ratio=0.4),
        adjustable=Adjustable(methods=(), max_added_damping_ratio=0.0),
    )
    assert offered_methods(settings) == ("kalman_fusion",)
    assert adjustment_refusal(Adjustment("kalman_fusion", 0.4), settings, State.IDLE) == ""
    why = adjustment_refusal(Adjustment("fused", nan), settings, State.IDLE)
    assert "one of kalman_fusion; controller.adjustable.methods" in why


def test_a_repeated_datagram_is_answered_once() -> None:
    adjusting = Adjusting(Settings(), 0.001)
    answers = [adjusting.judge(GAIN, cycle, State.IDLE) for cycle in (0, 4, 8)]
    assert answers[0] is not None and answers[1:] == [None, None]
    assert adjusting.judge(Adjustment("", nan), 12, State.IDLE) is not None  # nothing asked: refused
    assert adjusting.judge(GAIN, 5000, State.IDLE) is not None


def asking(at: dict[int, Adjustment]) -> object:
    def change(read: CycleInput) -> None:
        read.adjustment = at.get(read.cycle)

    return change


@pytest.mark.slow
@pytest.mark.parametrize("law", ["velocity", "composite"])
def test_a_gain_goes_over_at_zero_damping_without_a_step_of_the_command(law: str) -> None:
    damping = Damping(law=law, added_damping_ratio=0.06)  # type: ignore[arg-type]
    controller = Controller(MODEL, msgspec.structs.replace(SETTINGS, damping=damping))
    at = {2000: Adjustment("", 0.18)}
    trace = run(
        asking(at),  # type: ignore[arg-type]
        3.0,
        strikes={0.5: A, 1.7: A},
        reference=lambda t: 0.0,
        controller=controller,
    )
    answer = trace.outputs[2000].adjusted
    assert answer is not None and answer.refused == ""
    assert controller.settings.damping.added_damping_ratio == 0.18
    damped = np.array([output.damping_rad_s for output in trace.outputs])
    before, across = damped[1800:2000], damped[2030:2050]
    assert np.abs(before).max() > 2e-3 and np.abs(across).min() == 0.0
    # from full to nothing in fade_s = 0.04 s, besides its own swing: no single cycle takes a tenth of it
    assert np.abs(np.diff(damped[1990:2300])).max() < 0.1 * np.abs(before).max()
    if law == "velocity":
        k = 2.0 * 2.0 * np.pi * 2.6 / (1.14 * 2.0)  # docs/damping.md, for an added damping ratio of 1
        for span, ratio in ((slice(1800, 2000), 0.06), (slice(2260, 2500), 0.18)):
            followed = [output.predicted_deflection_m for output in trace.outputs[span]]
            assert np.polyfit(followed, damped[span], 1)[0] == pytest.approx(k * ratio, rel=0.1)


@pytest.mark.slow
def test_a_method_is_refused_while_damping_and_taken_where_nothing_is_damped() -> None:
    controller = Controller(MODEL, SETTINGS)
    at = {2000: METHOD, 2600: METHOD}

    def change(read: CycleInput) -> None:
        read.damping_allowed = read.cycle < 2300
        read.adjustment = at.get(read.cycle)

    trace = run(change, 3.5, strikes={0.5: A, 1.7: A, 3.0: A}, reference=lambda t: 0.0, controller=controller)
    refused, taken = trace.outputs[2000].adjusted, trace.outputs[2600].adjusted
    assert refused is not None and taken is not None
    assert "does not change while the state is damping; hold the damping, or disarm, first" in refused.refused
    assert refused.settings.method == SETTINGS.method and refused.told[0] == "warning"
    assert taken.refused == "" and controller.settings.method == "timestamps"
    assert states(trace, 2.6, 3.5) == {(State.ARMED, None)}
    assert trace.outputs[2601].estimate.delay.status == "unestimated"  # it begins anew
    assert trace.outputs[3400].estimate.delay.status == "estimated"


def test_what_a_model_cannot_have_is_refused_and_leaves_the_old_method() -> None:
    settings = Settings(method="timestamps", adjustable=Adjustable(methods=("unheard_of",)))
    controller = Controller(MODEL, settings)
    method = controller.method
    answer = controller.step(CycleInput(0, adjustment=Adjustment("unheard_of", 0.1))).adjusted
    assert answer is not None and "method 'unheard_of': unknown" in answer.refused
    assert controller.method is method and controller.settings is settings


def test_a_recorded_answer_becomes_the_same_request() -> None:
    controller = Controller(MODEL, SETTINGS)
    begun = settings_sample(0, 0.001, controller.settings, None)
    answer = controller.step(CycleInput(7, adjustment=GAIN)).adjusted
    told = settings_sample(7, 0.001, controller.settings, answer)
    assert (begun.added_damping_ratio, told.added_damping_ratio) == (0.12, 0.05)
    assert repr(adjustments([begun, told])) == repr({7: GAIN})
