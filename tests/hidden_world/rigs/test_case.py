"""Cases come from their seeds, are what they say, and a refit takes up what a baseline can."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.hidden_world.rigs.bundle import write_bundle
from tests.hidden_world.rigs.case import make
from tests.hidden_world.rigs.departure import departures, of_noise
from tests.hidden_world.rigs.draw import draw_rig
from tests.hidden_world.rigs.moves import draw_moves
from tests.hidden_world.rigs.recording import record
from tests.hidden_world.rigs.rig import Nuisance, Rig

pytestmark = pytest.mark.slow


def test_a_seed_gives_the_same_files(tmp_path: Path) -> None:
    for name in ("once", "again"):
        write_bundle(make(5, "lens_distortion"), tmp_path / name)
    for file in ("fast.csv", "frames.csv", "model.toml", "truth.json"):
        assert (tmp_path / "once" / file).read_bytes() == (tmp_path / "again" / file).read_bytes()


def test_another_seed_gives_another_rig() -> None:
    assert draw_rig(5).length_m != draw_rig(6).length_m


@pytest.mark.parametrize("what", ["none", "mains_hum", "image_scale_drift", "delay_bursts"])
def test_the_truth_says_what_the_files_hold(what: str, tmp_path: Path) -> None:
    case = make(21, what)
    write_bundle(case, tmp_path)
    truth = json.loads((tmp_path / "truth.json").read_text())
    matters = any(d["of_what_matters"] > 1.0 for d in truth["seen"].values())
    verdict = {"none": "none", "image_scale_drift": "unexplained"}.get(what, "named")
    assert truth["expected"] == (verdict if matters else "none")
    assert [e["cause"] for e in truth["effects"]] == ([] if what == "none" else [what])
    assert truth["nuisance_in_noise"] <= 0.5
    rows = (tmp_path / "fast.csv").read_text().splitlines()
    assert len(rows) == 1 + case.rig.cycles


def test_received_times_ascend_and_follow_their_exposures() -> None:
    for seed in range(8):
        rig = draw_rig(seed)
        seen = record(rig, [], noise=False).images
        assert np.all(np.diff(seen.received_s) > 0.0) and np.all(np.diff(seen.index) >= 1)
        assert np.all(seen.received_s > seen.middle_s + 0.5 * rig.camera.exposure_s)
        assert np.all(seen.started_s < seen.received_s)


def off(rig: Rig) -> Rig:
    """The rig as a model file that is a little wrong has it."""
    first = rig.modes[0]
    wrong = replace(
        first,
        frequency_hz=1.001 * first.frequency_hz,
        damping_ratio=1.1 * first.damping_ratio,
        participation=1.02 * first.participation,
    )
    camera = replace(
        rig.camera, scale_px_per_m=1.01 * rig.camera.scale_px_per_m, offset_px=rig.camera.offset_px + 2.0
    )
    return replace(rig, modes=(wrong, *rig.modes[1:]), camera=camera)


@pytest.mark.parametrize("seed", [1, 4, 6])
def test_what_a_baseline_refits_is_taken_up(seed: int) -> None:
    rig = replace(draw_rig(seed), nuisance=Nuisance())
    rig = replace(rig, encoder=None, camera=replace(rig.camera, rotation_px_per_rad=0.0))
    moves = draw_moves(rig)
    right, wrong = record(rig, moves, noise=False), record(off(rig), moves, noise=False)
    raw, rest = of_noise(departures(wrong, right)), of_noise(departures(wrong, right, moves))
    assert raw > 5.0 and rest < 0.02 * raw
