"""`demo --hide`: the drawn effect goes into the rig's model only."""

from pathlib import Path

import msgspec
import pytest

from stillarm.common.causes import CAUSES
from stillarm.common.files.effects_check import check_effects
from stillarm.common.files.model import load_model
from stillarm.common.files.scenario import load_scenario
from stillarm.common.user_error import UserError
from stillarm.progress import progress_bar
from stillarm.simulation.demo.demo import run_demo
from stillarm.simulation.demo.hidden_effect import draw_effect, revealing_moves
from stillarm.simulation.demo.set_up import write_demo_configuration
from stillarm.simulation.virtual_time.simulated_recording import default_simulation_configuration

DURATION_S = 60.0


def test_every_cause_is_drawn_with_a_usual_size_and_an_onset_inside_the_run() -> None:
    drawn = [draw_effect(seed, DURATION_S) for seed in range(600)]
    assert {effect["cause"] for effect in drawn} == set(CAUSES)
    assert drawn == [draw_effect(seed, DURATION_S) for seed in range(600)]
    signs: dict[tuple[str, str], set[bool]] = {}
    for effect in drawn:
        check_effects([effect], "drawn")
        cause = CAUSES[str(effect["cause"])]
        for parameter in cause.parameters:
            value = effect[parameter.name]
            if parameter.name == "onset_s":
                assert isinstance(value, float) and 0.3 * DURATION_S <= value <= 0.7 * DURATION_S
            elif parameter.kind in {"number", "whole"}:
                assert isinstance(value, int | float)
                neutral = 0.0 if parameter.neutral != parameter.neutral else parameter.neutral
                low, high = parameter.typical
                assert 0.999 * low <= abs(value - neutral) <= 1.001 * high
                if parameter.signed:
                    signs.setdefault((cause.identifier, parameter.name), set()).add(value > neutral)
        assert effect.get("clock") in {None, "camera"}
    assert len(signs) > 10
    assert all(seen == {True, False} for seen in signs.values())


def files(folder: Path, hide: int) -> dict[str, str]:
    folder.mkdir()
    write_demo_configuration(folder, DURATION_S, 3, hide=hide)
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_only_the_rigs_model_differs_from_one_hidden_effect_to_another(tmp_path: Path) -> None:
    """Configuration, assumed model and scenario tell that there is one, but not which; ports and names are new."""
    first, second = files(tmp_path / "a", 1), files(tmp_path / "b", 2)
    assert first["model.toml"] == second["model.toml"]
    assert load_model(tmp_path / "a" / "model.toml").effects == []
    assert load_model(tmp_path / "a" / "rig_model.toml").effects == [draw_effect(1, DURATION_S)]
    assert load_model(tmp_path / "b" / "rig_model.toml").effects == [draw_effect(2, DURATION_S)]
    bare = msgspec.structs.replace(load_model(tmp_path / "a" / "rig_model.toml"), effects=[])
    assert bare == load_model(tmp_path / "a" / "model.toml")
    assert first["scenario.toml"] == second["scenario.toml"]
    for cause in CAUSES:
        for name in ("config.toml", "model.toml", "scenario.toml"):
            assert cause not in first[name]

    def lines(text: str) -> list[str]:
        return [
            line
            for line in text.splitlines()
            if not any(w in line for w in ("port", "node", "demo-", "a/", "b/"))
        ]

    assert lines(first["config.toml"]) == lines(second["config.toml"])


def test_an_effect_hides_behind_another_accelerometer_too(tmp_path: Path) -> None:
    """The device goes into both models, the effect into the rig's alone."""
    write_demo_configuration(tmp_path, DURATION_S, 3, "adxl355", hide=4)
    assumed, true = (load_model(tmp_path / name) for name in ("model.toml", "rig_model.toml"))
    assert (assumed.effects, true.effects) == ([], [draw_effect(4, DURATION_S)])
    plain = load_model(default_simulation_configuration().with_name("model.toml"))
    assert true.accelerometer.noise_std_m_s2 == assumed.accelerometer.noise_std_m_s2
    assert true.accelerometer.noise_std_m_s2 != plain.accelerometer.noise_std_m_s2


@pytest.mark.parametrize("duration_s", [30.0, 60.0, 123.0])
def test_the_moves_fit_between_the_strikes_reverse_and_come_back(tmp_path: Path, duration_s: float) -> None:
    write_demo_configuration(tmp_path, duration_s, 0, hide=0)
    scenario = load_scenario(tmp_path / "scenario.toml")
    assert len(scenario.moves) >= 6
    assert min(move.start_s for move in scenario.moves) >= 0.42 * duration_s
    assert max(move.end_s for move in scenario.moves) <= scenario.damping[0].on_s
    way, furthest, slow, fast = 0.0, 0.0, False, False
    for cycle in range(round(1000 * duration_s)):
        velocity = scenario.reference_rad_s(0.001 * cycle)
        way += 0.001 * velocity
        furthest = max(furthest, abs(way))
        slow |= velocity < -0.02
        fast |= velocity > 0.19
    assert abs(way) < 1e-3
    assert slow and fast and 0.1 < furthest < 0.2
    assert revealing_moves(0.0, 4.9) == []


def test_too_short_a_run_is_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"^--duration-s 20: at least 30 s [^\n]+--hide$"):
        run_demo(tmp_path / "d", 20.0, 0, progress_bar, hide=1)
    assert not (tmp_path / "d").exists()
