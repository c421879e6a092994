"""The report's sections, each as HTML."""

import re
from html import escape
from typing import Any

from stillarm.common.causes import CAUSES
from stillarm.diagnosis.report import panels
from stillarm.diagnosis.report.case import Case, cases, whole
from stillarm.diagnosis.report.drawing import Picture, svg
from stillarm.diagnosis.report.picture import picture, picture_of_all
from stillarm.diagnosis.report.residuals import WORDS, ChannelResidual, examine_channel
from stillarm.diagnosis.report.result import Result
from stillarm.diagnosis.report.use import MEASURES, outcome
from stillarm.diagnosis.report.words import (
    NAMES,
    next_steps,
    not_tried,
    number,
    unit_of,
    use_sentence,
    why_not,
)

_MOST_CANDIDATES = 8
_EXACT = 1e-6  # of the signal: what rounding leaves


def table(head: list[str], rows: list[list[str]], *, numeric: int = 99) -> str:
    """A table; cells are HTML; columns from `numeric` on are aligned as numbers."""
    tags = ["th" if one else "td" for one in head]  # a head without words is none for who hears the page
    cells = "".join(
        f"<{tag}{_right(i, numeric)}>{one}</{tag}>"
        for i, (tag, one) in enumerate(zip(tags, head, strict=True))
    )
    body = "".join(
        "<tr>" + "".join(f"<td{_right(i, numeric)}>{one}</td>" for i, one in enumerate(row)) + "</tr>"
        for row in rows
    )
    return f"<div class=scroll tabindex=0><table><thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table></div>"


def _right(column: int, numeric: int) -> str:
    return " class=n" if column >= numeric else ""


def findings(result: Result) -> str:
    """Each finding: what it is, its picture, its numbers."""
    parts = [_finding(case, one) for case, one in zip(cases(result), result.table["findings"], strict=True)]
    left = result.table["unexplained"]
    if left is not None:
        parts.append(_unexplained(result, left))
    elif not parts:
        parts.append(f"<figure>{svg(picture_of_all(result))}</figure>")
    return "".join(parts)


def _finding(case: Case, one: dict[str, Any]) -> str:
    cause = CAUSES[one["cause"]]
    rows = [
        [
            f"<code>{escape(name)}</code>",
            number(value["value"], value["std"]),
            escape(unit_of(one["cause"], name)),
        ]
        for name, value in one["parameters"].items()
    ]
    held = one["held_out"]
    near = one["indistinguishable_from"]
    others = (
        "<p class=note>This recording cannot tell it from "
        + " or ".join(f"<code>{escape(name)}</code> ({escape(NAMES[name])})" for name in near)
        + f". What would: {escape(one['experiment'] or '')}.</p>"
        if near
        else ""
    )
    note = f"<p class=note>{escape(one['note'])}</p>" if one.get("note") else ""
    return (
        f"<section><h2>{escape(NAMES[one['cause']].capitalize())} <code>{escape(one['cause'])}</code></h2>"
        f"<p>{escape(_sentence(cause.sees))} In the simulation: <code>{escape(cause.equation)}</code>.</p>"
        f"<figure>{svg(picture(case))}</figure>"
        f"{table(['parameter', 'value', 'unit'], rows)}"
        f"<p>Confidence {100.0 * one['confidence']:.0f} %. Held out, it gains {held['log_score_gain']:.0f} nats of "
        f"likelihood (± {case.finding.held_out_std if case.finding else 0.0:.0f} over the held-out blocks); in the "
        f"channel that it mends most the error goes from {held['nrmse_before']:.3g} to "
        f"{held['nrmse_after']:.3g} of the signal, "
        f"{100.0 * held['reduction']:.0f} % less.</p>{others}{note}</section>"
    )


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:] + "."


def _unexplained(result: Result, left: dict[str, Any]) -> str:
    name, (low, high) = left["channel"], left["band_hz"]
    return (
        "<section><h2>What is left, and has no name</h2>"
        f"<p>In the {escape(WORDS[name])}, between {low:.3g} and {high:.3g} Hz; it depends on: "
        f"{escape(left['dependence'])}. {_term(left['term'])}</p>"
        f"<figure>{svg(picture_of_all(result))}</figure></section>"
    )


def _term(term: str) -> str:
    if not term:
        return "No term of the simulated state predicts it."
    return (
        "For prediction only, without a physical meaning, a regression on the simulated state gives "
        f"<code>{escape(term)}</code>."
    )


def gains(result: Result) -> str:
    """Per channel: held-out error before and after on the noise floor. A loss is shown like a gain."""
    rows = []
    for name, one in result.table["channels"].items():
        before, after, floor = one["nrmse_before"], one["nrmse_after"], one["noise_floor"]
        exact = max(before, after) < _EXACT
        change = 100.0 * (after / before - 1.0) if before and not exact else 0.0
        mark = "worse" if change > 0.5 else ("better" if change < -0.5 else "")
        rows.append(
            [
                escape(WORDS[name]),
                "" if exact else _bar(before, after, floor),
                str(one["samples"]),
                f"{before:.4g}",
                f"{after:.4g}",
                f"{floor:.4g}",
                "exact" if exact else f"<span class='{mark}'>{change:+.1f} %</span>",
                "yes" if one["white_before"] else "no",
                "yes" if one["white_after"] else "no",
            ]
        )
    head = ["channel", "", "held-out samples", "before", "after", "floor", "change", "white before", "after"]
    return (
        "<section><h2>What it gains, channel by channel</h2>"
        f"{table(head, rows, numeric=2)}"
        "<p class=note>Errors of the simulation in free run on samples that no fit has seen, over the standard "
        "deviation of the measured channel on the same samples. Before: the model as given, its own parameters "
        "refitted. Floor: noise from sample to sample. White: no structure left to predict. Bars: orange before, blue "
        "after, green line floor.</p></section>"
    )


def _bar(before: float, after: float, floor: float) -> str:
    top = max(before, after, floor, 1e-12)

    def width(value: float) -> str:
        return f"{120.0 * value / top:.1f}"

    return (
        "<svg class=bar viewBox='0 0 124 14' role=img aria-label='before, after, floor'>"
        f"<rect y=1 height=5 width={width(before)} fill='var(--before)' />"
        f"<rect y=8 height=5 width={width(after)} fill='var(--after)' />"
        f"<line x1={width(floor)} x2={width(floor)} y1=0 y2=14 stroke='var(--floor)' stroke-width=2 /></svg>"
    )


def considered(result: Result) -> str:
    """The ranking at each step, and why the others were not taken."""
    parts = []
    for number_of, stage in enumerate(result.found.stages, start=1):
        rows = []
        for one in stage.candidates[:_MOST_CANDIDATES]:
            values = ", ".join(
                f"{escape(name)} {number(value, std)}" for name, (value, std) in one.values.items()
            )
            dropped = stage.taken is one and one not in result.found.findings
            reason = (
                "taken, and dropped again: later findings made it needless"
                if dropped
                else why_not(one, stage)
            )
            rows.append(
                [
                    f"<code>{escape(one.cause)}</code> {escape(one.form)}",
                    escape(reason),
                    values,
                    f"{one.held_out_gain:+.1f} ± {one.held_out_std:.1f}",
                    f"{one.merit:+.1f}",
                ]
            )
        seen = {one.cause for one in stage.candidates}
        rest: dict[str, float] = {}
        for scored in stage.screening:
            if scored.cause.id not in seen:
                rest[scored.cause.id] = max(rest.get(scored.cause.id, 0.0), scored.nats)
        weak = ", ".join(f"{escape(name)} ({nats:.1f})" for name, nats in rest.items())
        outcome = f"taken: <code>{escape(stage.taken.cause)}</code>" if stage.taken else "nothing taken"
        parts.append(f"<h3>Step {number_of}: {outcome}</h3>")
        if rows:
            head = [
                "cause",
                "outcome",
                "parameters",
                "held-out gain, nats",
                "all data, less its numbers' price, nats",
            ]
            parts.append(table(head, rows, numeric=3))
        if weak:
            parts.append(
                "<p class=note>Screened and left, with the gain that a first-order test promises, nats: "
                f"{weak}.</p>"
            )
    absent = not_tried(result)
    if absent:
        parts.append(
            "<p class=note>Not to be seen in this recording, since what would show them was not recorded or did not "
            f"move: {', '.join(escape(name) for name in absent)}.</p>"
        )
    return f"<section><h2>What else was considered</h2>{''.join(parts)}</section>"


def baseline(result: Result) -> str:
    """Parameters of the model that were merely off, and events."""
    changes = result.table["baseline_changes"]
    parts = []
    if changes:
        rows = [
            [
                f"<code>{escape(key)}</code>",
                f"{one['configured']:.5g}",
                number(one["fitted"], one["std"]),
            ]
            for key, one in changes.items()
        ]
        parts.append(table(["model key", "configured", "fitted"], rows, numeric=1))
    else:
        parts.append("<p>All of the model's own parameters agree with this recording.</p>")
    events = result.table["events"]
    if events:
        times = ", ".join(f"{one['kind']} at {one['time_s']:.2f} s" for one in events)
        parts.append(
            f"<p>What no sensor measured: {times}. From each on the arm has a state of its own, fitted; what shows "
            "while something pulls at it is not judged.</p>"
        )
    return f"<section><h2>Parameters that were merely off, and events</h2>{''.join(parts)}</section>"


def residuals(result: Result) -> str:
    """Every channel's residual: in time, its spectrum, what it follows, and the tests."""
    case = whole(result)
    parts = []
    for name in case.channels:
        before, after = examine_channel(case.before, name), examine_channel(case.after, name)
        shown = [panels.residual_in_time(case, name), panels.residual_spectrum(case, name)]
        strong = [one for one in (*before.dependences, *after.dependences) if one.significant]
        if strong:
            shown.append(panels.residual_against(case, name, strong[0].variable))
        drawn = Picture(shown, f"residual of the {name}", (13.0 / len(shown), 2.6))
        same = before.sentences == after.sentences or not result.found.findings
        lists = (
            _sentences("", after) if same else _sentences("Before: ", before) + _sentences("After: ", after)
        )
        parts.append(f"<h3>{escape(WORDS[name].capitalize())}</h3><figure>{svg(drawn)}</figure>{lists}")
    return (
        "<section><h2>What each channel shows</h2>"
        "<p class=note>Tests hold for coloured residuals: correlations against Bartlett's bands, dependences against "
        "the signs of whole blocks drawn at random, each with one false alarm in a hundred. In closed loop the tests "
        f"are against the external reference.</p>{''.join(parts)}</section>"
    )


def _sentences(word: str, found: ChannelResidual) -> str:
    return f"<p>{'<b>' + word + '</b>' if word else ''}{escape(' '.join(found.sentences))}</p>"


def use(result: Result) -> str:
    """What the extended model is worth to the controller."""
    found = result.table.get("use")
    if not found:
        return ""
    note = f"<p class=note>{escape(_sentence(found['note']))}</p>" if found["note"] else ""
    if found["before"] is None:
        return f"<section><h2>What it is worth in use</h2>{note}</section>"
    rows = []
    for key, one in MEASURES.items():
        before, after = found["before"][key], found["after"][key]
        change = 100.0 * (after / before - 1.0) if before else 0.0
        spread = f" ± {100.0 * found['spread'][key] / before:.0f} %" if found["spread"] and before else ""
        rows.append(
            [
                escape(one.words),
                one.shown(before),
                one.shown(after),
                f"<span class='{outcome(found, key)}'>{change:+.0f} %</span>{spread}",
            ]
        )
    return (
        "<section><h2>What it is worth in use</h2>"
        f"{table(['', 'model as given', 'extended model', 'change'], rows, numeric=1)}"
        "<p class=note>The controller in virtual time on a rig that is the extended model, with each model; "
        f"parts of the impact's amplitude. {escape(use_sentence(found))}</p>{note}</section>"
    )


def what_next(result: Result) -> str:
    """What to do."""
    steps = "".join(f"<li>{_marked(one)}</li>" for one in next_steps(result))
    return f"<section><h2>What to do next</h2><ol>{steps}</ol></section>"


def _marked(text: str) -> str:
    """Text with what stands in backticks as code."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", escape(text))
