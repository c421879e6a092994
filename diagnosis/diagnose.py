"""One call: measured data in, diagnosis out. docs/diagnosis.md tells how it decides."""

from collections.abc import Sequence
from math import inf
from pathlib import Path

import msgspec

from stillarm.common.files.effects import declared
from stillarm.common.files.model import Model, check_model, refuse_driven_effects
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.recording.reader import Recording, open_recording
from stillarm.common.user_error import UserError
from stillarm.diagnosis.data.measured import Measured
from stillarm.diagnosis.data.reading import read_measured
from stillarm.diagnosis.decision.budget import Budget, unlimited
from stillarm.diagnosis.decision.run import Tick, run
from stillarm.diagnosis.driven.diagnosed import DrivenResult, diagnose_driven
from stillarm.diagnosis.driven.recording.signals import is_driven
from stillarm.diagnosis.events.frequency_course import with_resonance_of
from stillarm.diagnosis.fitting.fitted import refitted_model
from stillarm.diagnosis.physics.declared_effects import with_found
from stillarm.diagnosis.report import tables as say
from stillarm.diagnosis.report.extended_model import baseline_changes, effects_of
from stillarm.diagnosis.report.result import Result

_SHORTEST_S, _FEWEST_PAIRS = 3.0, 128  # of a recording; samples of a pair


def model_of(recording: Recording) -> Model:
    """The model that the recording carries. Raises UserError."""
    text = recording.header.model
    if not text.strip():
        return Model()
    return check_model(
        parse_toml(text, Model, f"{recording.path} (its model)"), f"{recording.path} (its model)"
    )


def diagnose(
    path: str | Path,
    model: Model | None = None,
    hold_out: Sequence[tuple[float, float]] = (),
    tick: Tick = lambda done, what: None,
    budget: Budget | None = None,
) -> Result | DrivenResult:
    """Diagnose one recording. Raises UserError where it holds too little."""
    budget = budget or unlimited()
    recording = open_recording(path)
    given = model is not None or bool(recording.header.model.strip())
    model = model or model_of(recording)
    if is_driven(recording):
        return _diagnose_driven(recording, model if given else None, hold_out, tick, budget)
    refuse_driven_effects(model, f"{path} (its model)")
    tick(0.02, "reading")
    measured = read_measured(recording, model)
    if measured.pair and measured.cycles < _FEWEST_PAIRS:
        raise UserError(
            f"{path}: {measured.cycles} samples are too few for a diagnosis; give at least {_FEWEST_PAIRS}"
        )
    if measured.duration_s < _SHORTEST_S and not measured.pair:
        raise UserError(
            f"{path}: {measured.duration_s:.1f} s are too short for a diagnosis; record 20 s or more"
        )
    if measured.pair and not given:
        model = with_resonance_of(measured, model)
    result = diagnose_measured(measured, model, hold_out, tick, budget)
    result.table["looked_at"]["incomplete"] = recording.incomplete
    return result


def _diagnose_driven(
    recording: Recording,
    model: Model | None,
    hold_out: Sequence[tuple[float, float]],
    tick: Tick,
    budget: Budget,
) -> DrivenResult:
    def left_s() -> float:
        return inf if budget.seconds is None else budget.stages_s - budget.used_s

    result = diagnose_driven(recording, model, hold_out, tick, left_s)
    result.table["looked_at"] |= {
        "seconds": budget.used_s,
        "budget_s": budget.seconds,
        "incomplete": recording.incomplete,
    }
    return result


def diagnose_measured(
    measured: Measured,
    model: Model,
    hold_out: Sequence[tuple[float, float]] = (),
    tick: Tick = lambda done, what: None,
    budget: Budget | None = None,
) -> Result:
    """Diagnose data that are already in memory. Raises UserError where they show nothing."""
    budget = budget or unlimited()
    model = declared(model)
    outcome = run(measured, model, hold_out, tick, budget)
    found, judged, split = outcome.found, outcome.judged, outcome.split
    extended = refitted_model(model, found.final)
    effects = [each for one in found.findings for each in effects_of(one, found.final)]
    extended = msgspec.structs.replace(extended, effects=with_found(model.effects, effects))
    table = {
        "verdict": judged.verdict,
        "channels": say.channel_table(found, split),
        "findings": say.findings_table(found, judged, split),
        "unexplained": say.unexplained_table(judged),
        "left": say.left_table(judged),
        "events": say.events_table(found),
        "looked_at": {
            "seconds": budget.used_s,
            "budget_s": budget.seconds,
            "left_out": outcome.left_out,
        },
        "channels_left_out": outcome.channels_left_out,
        "baseline_changes": baseline_changes(model, found.final),
        "extended_model": "extended.toml",
    }
    return Result(table, found, judged, split, model, extended)
