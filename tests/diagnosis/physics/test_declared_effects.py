"""A recording is held against its model's effects: those that it has are no news, another amount of one is."""

from pathlib import Path

import msgspec
import pytest

from stillarm.common.causes import CAUSES
from stillarm.common.files.effects import FOLDED_CAUSES, declared
from stillarm.common.files.effects_check import check_effects
from stillarm.diagnosis.diagnose import diagnose
from stillarm.diagnosis.physics.declared_effects import declared_quantities, with_found
from tests.fixtures.simulated import MODEL, SIZES, effect, record

BY_CHANCE = {"impulse_noise", "frame_drops", "delay_bursts", "clock_step"}


@pytest.mark.parametrize("cause", sorted(set(CAUSES) - FOLDED_CAUSES - BY_CHANCE))
def test_every_effect_that_is_none_of_a_key_s_and_none_of_chance_is_obeyed(cause: str) -> None:
    known = declared(msgspec.structs.replace(MODEL, effects=[effect(cause)]))
    assert set(declared_quantities(known)) and declared_quantities(MODEL) == {}


def test_what_is_found_again_takes_the_place_of_what_was_declared() -> None:
    old, other, new = effect("cubic_stiffness"), effect("joint_friction"), {**effect("cubic_stiffness")}
    new["coefficient_per_m2"] = 170.0
    both = with_found([old, other], [new])
    check_effects(both, "both")
    assert both == [other, new]


@pytest.mark.blind(each_run=1, group="a recording of what its model declares")
def test_an_extended_model_s_recording_holds_nothing_unknown(tmp_path: Path) -> None:
    effects = [effect("cubic_stiffness"), effect("gravity_leakage"), effect("drive_lag"), effect("mains_hum")]
    recording = record(tmp_path, *effects)
    known = msgspec.structs.replace(MODEL, effects=[*effects[:3], {**effects[3], "phase_rad": 2.9}])
    result = diagnose(recording, known)
    assert result.table["verdict"] == "none", result.table["findings"]
    assert not result.table["findings"]


@pytest.mark.blind(each_run=1, seed=3, group="a recording of what its model declares")
@pytest.mark.parametrize(
    ("cause", "amount"),
    [
        ("cubic_stiffness", "coefficient_per_m2"),
        ("gravity_leakage", "gain_m_s2_per_rad"),
        ("tracking_drift", "rate_px_per_s"),
        ("quadratic_damping", "coefficient_per_m"),
    ],
)
def test_another_amount_of_a_known_effect_is_found_and_replaces_it(
    cause: str, amount: str, tmp_path: Path
) -> None:
    recording = record(tmp_path, effect(cause))
    true = SIZES[cause][amount]
    less = effect(cause, **{amount: 0.6 * true})
    result = diagnose(recording, msgspec.structs.replace(MODEL, effects=[less]))
    assert [one["cause"] for one in result.table["findings"]] == [cause]
    (found,) = result.extended.effects
    assert found[amount] == pytest.approx(true, rel=0.1)
