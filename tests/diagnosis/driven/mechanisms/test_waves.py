"""A torque ripple's wave, beside what a world of its own hides."""

import json
from pathlib import Path

import pytest

from stillarm.benchmarks.diagnosis.driven import model_of_stated
from stillarm.common.files.model import load_model
from stillarm.diagnosis.driven.mechanisms.waves import strongest_waves
from stillarm.diagnosis.driven.recording.blocks import irregular
from stillarm.diagnosis.driven.starts.start import linear_start
from stillarm.diagnosis.driven.starts.stated import stated_by
from tests.fixtures.driven_world import driven_of
from tests.hidden_world.driven.case import make
from tests.hidden_world.driven.files import write_case


@pytest.mark.slow
def test_the_strongest_wave_is_the_ripples() -> None:
    """Its encoder is so noisy that the twice differentiated angle shows nothing; the velocity does."""
    case = make(424200037, "torque_ripple")
    assert case.effect is not None
    driven = driven_of(case)
    start = linear_start(driven, irregular(driven.duration_s))
    strongest = strongest_waves(start)[0]
    turns = 12.0 + 60.0 * case.effect.chance[0]
    assert strongest.cycles == pytest.approx(turns, abs=1.0)
    size = case.effect.size / case.rig.inertia
    assert (strongest.sine**2 + strongest.cosine**2) ** 0.5 == pytest.approx(size, rel=0.15)


@pytest.mark.slow
def test_a_wave_behind_a_stated_gear_is_one_over_the_joints_angle(tmp_path: Path) -> None:
    """The motor's encoder turns fifty times as far."""
    case = make(7008000018, "torque_ripple")
    write_case(case, tmp_path / "case")
    stated = json.loads((tmp_path / "case" / "stated.json").read_text())
    (tmp_path / "model.toml").write_text(model_of_stated(stated))
    driven = driven_of(case)
    known = stated_by(load_model(tmp_path / "model.toml"), driven, "model.toml")
    strongest = strongest_waves(linear_start(driven, irregular(driven.duration_s), known))[0]
    assert strongest.cycles == pytest.approx(52.0, abs=1.0)
