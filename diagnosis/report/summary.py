"""The three sentences with which a report begins: what is wrong, how sure that is, what to do about it."""

from stillarm.common.causes import CAUSES, experiment_between
from stillarm.diagnosis.decision.rival_causes import runner_up
from stillarm.diagnosis.forms.causes import CAUSES as SEARCHED
from stillarm.diagnosis.report.residuals import UNITS, WORDS
from stillarm.diagnosis.report.result import Result
from stillarm.diagnosis.report.tables import NOTHING_LIKE_IT
from stillarm.diagnosis.report.words import NAMES, not_tried, verdict_sentence
from stillarm.diagnosis.search.candidates import Candidate

_MOST = 99  # per cent that a confidence is told to


def summary(result: Result) -> tuple[str, str, str]:
    """What is wrong, how sure that is, and what to do, a sentence each."""
    how_sure, what_to_do = {
        "named": (_sure_of_a_name, _do_about_a_name),
        "none": (_sure_of_nothing, _do_about_nothing),
        "unexplained": (_sure_of_no_name, _do_about_no_name),
    }[result.table["verdict"]]
    return verdict_sentence(result), how_sure(result) + _left_out(result), what_to_do(result)


def _left_out(result: Result) -> str:
    """The end of the second sentence: what the time did not suffice for bears on how sure anything is."""
    left_out = [one for one in result.table["looked_at"]["left_out"] if one != "use"]
    return f"; the time did not suffice for {' and '.join(left_out)}." if left_out else "."


def _per_cent(confidence: float) -> str:
    return f"{min(100.0 * confidence, _MOST):.0f} %"


def _rival_of(result: Result) -> Candidate | None:
    """The best other explanation when the first finding was taken, of those that explain anything."""
    rival = runner_up(result.found, result.found.findings[0])
    return rival if rival is not None and rival.merit > 0.0 else None


def _sure_of_a_name(result: Result) -> str:
    first, *others = result.table["findings"]
    sure = _per_cent(first["confidence"])
    near = first["indistinguishable_from"]
    rival = _rival_of(result)
    if near:
        text = f"The confidence in each of these two names is {sure}: this recording cannot tell them apart"
    elif rival is not None:
        behind = result.found.findings[0].merit - rival.merit
        text = (
            f"The confidence in this is {sure}: the next best explanation, {NAMES[rival.cause]}, foretells the "
            f"recording worse by {behind:.0f} nats"
        )
    else:
        text = f"The confidence in this is {sure}: no other cause gains more than chance"
    for one in others:
        text += f"; in {NAMES[one['cause']]} it is {_per_cent(one['confidence'])}"
    return text


def _do_about_a_name(result: Result) -> str:
    first = result.table["findings"][0]
    if first["indistinguishable_from"]:
        return f"To tell the two apart, {first['experiment']}."
    rival = _rival_of(result)
    between = experiment_between(first["cause"], rival.cause) if rival is not None else None
    if rival is not None and between is not None:
        confirm = f"; to be sure that it is not {NAMES[rival.cause]}, {between}"
    else:
        confirm = f"; to confirm it, record this: {CAUSES[first['cause']].provoke.rstrip('.')}"
    return f"Mend it, or use extended.toml, the model with it{confirm}."


def _sure_of_nothing(result: Result) -> str:
    count = len(SEARCHED) - len(not_tried(result))
    left = max(result.judged.rests, key=lambda one: one.share_of_noise, default=None)
    text = f"Of {count} causes that this recording can show none gains more than chance"
    if left is None or left.rms <= 0.0:
        return f"{text}, and nothing but noise is left"
    return (
        f"{text}, and no more is left than {left.rms:.2g} {UNITS[left.channel]} in the {WORDS[left.channel]}, "
        f"{left.share_of_noise:.2g} of its noise"
    )


def _do_about_nothing(result: Result) -> str:
    changes = result.table["baseline_changes"]
    after = "diagnose again after the rig has been changed, or has aged"
    if not changes:
        return f"Keep the model, and {after}."
    keys = ", ".join(list(changes)[:3]) + (" and more" if len(changes) > 3 else "")
    return f"Take over the refitted {keys} from extended.toml, and {after}."


def _sure_of_no_name(result: Result) -> str:
    findings, left = result.table["findings"], result.table["unexplained"]
    if findings:
        first = findings[0]
        text = f"The listed cause that comes closest is {NAMES[first['cause']]}, at a confidence of "
        text += _per_cent(first["confidence"])
    else:
        text = "No listed cause gains more than chance"
    if left["dependence"] == NOTHING_LIKE_IT:
        return f"{text}, and what is left resembles {NOTHING_LIKE_IT}"
    return f"{text}, and what is left looks most like {left['dependence']}"


def _do_about_no_name(result: Result) -> str:
    left = result.table["unexplained"]
    if left["dependence"] == NOTHING_LIKE_IT:
        low, high = left["band_hz"]
        return (
            f"Look for resonances of the rig between {low:.3g} and {high:.3g} Hz, add one that is known to the model "
            "as a mode, and diagnose again."
        )
    return "Record again with that alone varied, all else at rest, and diagnose both recordings."
