"""The campaign: every fault of both tables, repeated as requested."""

import random
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from stillarm.benchmarks.faults.judge import Verdict, table
from stillarm.benchmarks.faults.live_faults import FAULTS as LIVE_FAULTS
from stillarm.benchmarks.faults.live_faults import run_live_fault
from stillarm.benchmarks.faults.live_rig import LiveRig
from stillarm.benchmarks.faults.virtual_faults import FAULTS as VIRTUAL_FAULTS
from stillarm.benchmarks.faults.virtual_faults import run_virtual_fault
from stillarm.common.files.configuration import load_assumed_model, load_configuration
from stillarm.common.user_error import UserError
from stillarm.simulation.virtual_time.simulated_recording import default_simulation_configuration

_LIVE_SHARE = 4  # injections in virtual time for each live one

Progress = Callable[[float], None]


def run(trials: int, seed: int, progress: Progress = lambda done: None) -> dict[str, Any]:
    """Inject every virtual fault `trials` times and every live one a quarter as often, at least once."""
    live = max(1, trials // _LIVE_SHARE)
    whole = len(VIRTUAL_FAULTS) * trials + 5 * len(LIVE_FAULTS) * live
    path = default_simulation_configuration()
    configuration = load_configuration(path)
    model = load_assumed_model(configuration, path)
    verdicts: list[Verdict] = []
    for kind in VIRTUAL_FAULTS:
        verdicts += run_virtual_fault(kind, configuration, model, trials, seed)
        progress(len(verdicts) / whole)
    verdicts += run_live(
        live, seed, lambda done: progress((len(VIRTUAL_FAULTS) * trials * (1 - done) + whole * done) / whole)
    )
    return table(verdicts) | {"live_injections": live * len(LIVE_FAULTS)}


def run_live(times: int, seed: int, progress: Progress = lambda done: None) -> list[Verdict]:
    """Inject the live faults in random order. A rig that does not recover is replaced."""
    rng = random.Random(seed)
    order = [kind for kind in LIVE_FAULTS for _ in range(times)]
    rng.shuffle(order)
    verdicts: list[Verdict] = []
    rig: LiveRig | None = None
    with tempfile.TemporaryDirectory(prefix="stillarm-faults-") as folder:
        try:
            for count, kind in enumerate(order):
                if rig is None:
                    place = Path(folder) / str(count)
                    place.mkdir()
                    rig = LiveRig(place, seed + count)
                try:
                    verdicts.append(run_live_fault(kind, rig, rng))
                except UserError as error:
                    verdicts.append(Verdict(kind, violations=[str(error)]))
                if verdicts[-1].violations:
                    rig.close()
                    rig = None
                progress((count + 1) / len(order))
        finally:
            if rig is not None:
                rig.close()
    return sorted(verdicts, key=lambda verdict: list(LIVE_FAULTS).index(verdict.kind))
