"""The report's sentences."""

from math import floor, isfinite, log10
from typing import Any

from stillarm.common.causes import CAUSES
from stillarm.diagnosis.fitting.evidence import CONVINCING_NATS
from stillarm.diagnosis.forms.causes import CAUSES as SEARCHED
from stillarm.diagnosis.report.residuals import WORDS
from stillarm.diagnosis.report.result import Result
from stillarm.diagnosis.report.tables import NOTHING_LIKE_IT, is_sure_of
from stillarm.diagnosis.report.use import MEASURES, outcome
from stillarm.diagnosis.search.candidates import Candidate, Stage

NAMES = {identifier: cause.name for identifier, cause in CAUSES.items()}


def number(value: float, std: float | None = None) -> str:
    """A value with as many digits as its standard deviation has meaning for, two of the deviation's."""
    if std is None or not std > 0.0 or not isfinite(std):
        return f"{value:.4g}"
    digits = 1 - floor(log10(std))
    if digits <= -3 or digits >= 9:
        return f"{value:.4g} ± {std:.2g}"
    if digits <= 0:
        return f"{round(value, digits):.0f} ± {round(std, digits):.0f}"
    return f"{value:.{digits}f} ± {std:.{digits}f}"


def unit_of(cause: str, parameter: str) -> str:
    """Unit of a cause's parameter."""
    unit = next((one.unit for one in CAUSES[cause].parameters if one.name == parameter), "")
    return "" if unit in ("", "1") else unit


def verdict_sentence(result: Result) -> str:
    """The verdict in one sentence."""
    table = result.table
    parts = [_named(one) for one in table["findings"] if is_sure_of(one, table)]
    unsure = [_named(one) for one in table["findings"] if not is_sure_of(one, table)]
    left = table["unexplained"]
    if table["verdict"] == "none":
        return "Nothing is wrong with this simulation beyond the values of its own parameters."
    if left is not None:
        low, high = left["band_hz"]
        rest = (
            f"the {WORDS.get(left['channel'], left['channel'])} holds structure at {low:.3g} to {high:.3g} Hz "
            "that none of the known causes explains"
        )
        if unsure:
            rest += f"; {', and '.join(unsure)} may be a small part of it, or only imitate one"
        if not parts:
            return rest[0].upper() + rest[1:] + "."
        return f"The simulation lacks {', and '.join(parts)}; beyond that, {rest}."
    return f"The simulation lacks {', and '.join(parts)}."


def use_sentence(use: dict[str, Any]) -> str:
    """What the extended model does better or worse in use, against the spread of paired runs where there are any."""
    if use["before"] is None:
        return f"In use: {use['note']}."
    changes = [
        f"{one.words.split(',')[0]} {one.shown(use['before'][key])} to {one.shown(use['after'][key])}, {how}"
        for key, one in MEASURES.items()
        if (how := outcome(use, key))
    ]
    pairs = "a single pair of runs" if use["pairs"] == 1 else f"{use['pairs']} pairs of runs"
    return f"In use, by {pairs}: {'; '.join(changes) or 'nothing is to be gained'}."


def _named(finding: dict[str, Any]) -> str:
    words = [NAMES[one] for one in (finding["cause"], *finding["indistinguishable_from"])]
    cut = 100.0 * finding["held_out"]["reduction"]
    if cut < 1.0:  # a law of noise or timing moves no mean
        gain = f"{finding['held_out']['log_score_gain']:.0f} nats of held-out likelihood gained"
    else:
        gain = f"the held-out error falls by {rounded_cut(cut)} %"
    return f"{' or '.join(words)} ({gain})"


def rounded_cut(percent: float) -> str:
    """A reduction in whole per cent; one that is not quite all is not rounded to all."""
    return "more than 99" if 99.5 <= percent < 100.0 else f"{percent:.0f}"


def unread(table: dict[str, Any]) -> str:
    """What of the recording could not be read, to follow a sentence without its stop; empty if all was."""
    lost = table["looked_at"].get("incomplete", "")
    return f". The recording is incomplete: {lost}" if lost else ""


def why_not(one: Candidate, stage: Stage) -> str:
    """Why a candidate was not taken."""
    taken = stage.taken
    if taken is one:
        return "taken"
    failed = _failed(one, stage)
    if failed or taken is None:
        return failed or "less than a channel's usual discrepancy"
    return f"{taken.merit - one.merit:.0f} nats behind {taken.cause}"


def _failed(one: Candidate, stage: Stage) -> str:
    """The test that a candidate fails by itself; empty where it passes all."""
    if one.merit < CONVINCING_NATS:
        return "gains no more than chance and its numbers do"
    return implausible(one)


def implausible(one: Candidate) -> str:
    """The parameter that lies outside of the catalogue's range; empty where none does."""
    for parameter in CAUSES[one.cause].parameters:
        if parameter.name not in one.values or parameter.kind not in ("number", "whole"):
            continue
        value = one.values[parameter.name][0]
        if not parameter.lowest <= value <= parameter.highest:
            return f"{parameter.name} = {value:.4g} is not possible"
    return ""


def not_tried(result: Result) -> list[str]:
    """Causes that this recording cannot show: what would show them was not recorded, or did not move."""
    world = result.found.baseline.world
    return [name for name, cause in SEARCHED.items() if not cause.needs(world)]


def next_steps(result: Result) -> list[str]:
    """What to do next."""
    table = result.table
    steps = []
    for finding in table["findings"]:
        if finding["experiment"]:
            names = " and ".join([finding["cause"], *finding["indistinguishable_from"]])
            steps.append(f"To tell {names} apart: {finding['experiment']}.")
    if table["unexplained"]:
        left = table["unexplained"]
        where = f"What is left in the {WORDS.get(left['channel'], left['channel'])}"
        if left["dependence"] == NOTHING_LIKE_IT:
            steps.append(
                f"{where} resembles nothing that was tried. Look for resonances in the shaded band of its spectrum; "
                "where the rig is known to have one, add it to the model as a mode and diagnose again."
            )
        else:
            steps.append(
                f"{where} looks most like {left['dependence']}. Record again with that alone varied, all else at rest, "
                "and diagnose both recordings."
            )
    sure = all(is_sure_of(one, table) for one in table["findings"])
    if table["findings"] or table["baseline_changes"]:
        steps.append(
            "extended.toml beside this page is the model with these changes: give it to `stillarm simulate --model`, "
            "or to the controller's configuration as its model. Diagnose a new recording with it "
            "(`stillarm diagnose REC --model extended.toml`): "
            + (
                "it should say that nothing is wrong."
                if sure and not table["unexplained"]
                else "it shows what lasts."
            )
        )
    else:
        steps.append("Keep the model. Diagnose again after the rig has been changed, or has aged.")
    if not result.found.baseline.world.measured.pair:
        missing = [
            WORDS[name]
            for name in ("acceleration", "displacement", "joint_position")
            if name not in table["channels"]
        ]
        if missing:
            steps.append(f"Record the {' and the '.join(missing)} too: more causes could then be told apart.")
    return steps
