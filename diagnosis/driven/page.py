"""report.html of a driven joint: the verdict, the force that is missing as curves, and the numbers."""

from collections.abc import Callable, Sequence
from html import escape
from importlib.resources import files
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stillarm.common.causes.driven import DRIVEN_CAUSES
from stillarm.common.recording.header import program_version
from stillarm.diagnosis.driven.diagnosed import DrivenResult
from stillarm.diagnosis.driven.mechanisms.missing import Curve, MissingForce, missing_bend, missing_force
from stillarm.diagnosis.report.drawing import AFTER, BEFORE, MEASURED, Picture, figure, svg
from stillarm.diagnosis.report.words import rounded_cut, unread

_MOST_POINTS = 1200  # of a picture: more hide one another


def names_of(cause: str) -> str:
    """A cause in words."""
    return DRIVEN_CAUSES[cause].name if cause in DRIVEN_CAUSES else cause.replace("_", " ")


def sentences(result: DrivenResult) -> tuple[str, str, str]:
    """What is wrong, how sure that is, and what to do about it."""
    table = result.table
    start = f"The joint was identified from {table['start']['from']}"
    if table["verdict"] == "none":
        return (
            "Nothing is wrong with the joint's linear model beyond its parameters.",
            f"{start}, and no listed cause gains more than chance.",
            "Keep the model, and diagnose again after the rig has been changed.",
        )
    if not table["findings"]:
        left = table["unexplained"]
        return (
            f"The {left['channel'].replace('_', ' ')} holds structure that no listed cause explains.",
            f"{start}.",
            "Look at the curves of the missing force below.",
        )
    first = table["findings"][0]
    both = " or ".join(names_of(one) for one in (first["cause"], *first["indistinguishable_from"]))
    cut = 100.0 * first["held_out"]["reduction"]
    where = f" in {', '.join(first['only_in'])} only" if "only_in" in first else ""
    wrong = (
        f"The joint has {both} ({first['form']}){where}: the held-out error falls by {rounded_cut(cut)} %."
    )
    if table["verdict"] == "unexplained":
        wrong = f"No single cause explains most of it; the nearest is {both} ({first['form']})."
    do = (
        f"To tell them apart, {first['experiment']}."
        if first["experiment"]
        else "Mend it, or put its numbers into the model."
    )
    return wrong, f"The confidence in this is {100 * first['confidence']:.0f} %. {start}.", do


def main_figure(result: DrivenResult) -> Figure:
    """The missing force over the joint's angle and over its velocity, as a figure that belongs to no window."""
    return figure(curves(result))


def curves(result: DrivenResult) -> Picture:
    """The force that the start lacks, and what the final model gives in its place: on the joint, or without a sensor
    there on the arm; with neither, measured and simulated."""
    found = missing_before(result)
    if found is None:
        return Picture((_overlay(result),), "measured and simulated")
    final = result.verdict.final
    if found.mode and final.box.driven.joins:
        final = final.part(0)
    after = missing_bend(final) if found.mode else missing_force(final)
    assert after is not None
    given = final.run.forces[:, 1 if found.mode else 0]
    trimmed = (len(given) - len(after.force)) // 2
    law = given[trimmed : trimmed + len(after.force)]
    over = ("angle, rad", "velocity, rad/s")
    if found.mode:
        over = (f"deflection of mode {found.mode}", f"rate of mode {found.mode}")
    panels = [
        _curve(over[0], found.over_angle, found.theta, found, after.theta, law),
        _curve(over[1], found.over_velocity, found.omega, found, after.omega, law),
    ]
    return Picture(panels, "the force that the linear model lacks, over position and over velocity")


def missing_before(result: DrivenResult) -> MissingForce | None:
    """The force that the linear start lacks: on the joint, or without a sensor there on the arm. Where the search found
    more structure and no cause, what that lacks."""
    structure_alone = not result.verdict.findings
    fitted = result.verdict.final if structure_alone else result.searched.start
    joint = missing_force(fitted)
    return joint if joint is not None else missing_bend(fitted)


def _curve(
    over: str, curve: Curve, at: Any, before: MissingForce, law_at: Any, law: Any
) -> Callable[[Axes], None]:
    def draw(axes: Axes) -> None:
        every = max(1, len(at) // _MOST_POINTS)
        axes.plot(at[::every], before.force[::every], ".", color=MEASURED, ms=1.5, label="each sample")
        if len(curve.at):
            axes.errorbar(curve.at, curve.mean, 2.0 * curve.error, color=BEFORE, label="missing, mean")
        if np.any(law != 0.0):
            order = np.argsort(law_at)
            bins = np.array_split(order, 40)
            centre = [law_at[one].mean() if len(one) else nan for one in bins]
            axes.plot(
                centre,
                [law[one].mean() if len(one) else nan for one in bins],
                color=AFTER,
                label="causes found",
            )
        low, high = np.quantile(before.force, [0.01, 0.99])
        axes.set_ylim(low - 0.3 * (high - low), high + 0.3 * (high - low))
        axes.set_xlabel(over)
        axes.set_title(
            "missing force per modal mass" if before.mode else "missing acceleration of the joint, rad/s^2"
        )
        axes.legend(loc="best", fontsize=8)

    return draw


def _overlay(result: DrivenResult) -> Callable[[Axes], None]:
    def draw(axes: Axes) -> None:
        output, final = result.driven.outputs[0], result.verdict.final
        many = slice(0, min(len(output.values), 2000))
        t = np.arange(result.driven.samples)[many] * result.driven.step_s
        axes.plot(t, output.values[many], color=MEASURED, label="measured")
        axes.plot(t, final.run.outputs[output.name][many], color=AFTER, label="simulated")
        axes.set_xlabel("time, s")
        axes.set_title(output.name)
        axes.legend(loc="best", fontsize=8)

    return draw


def report_page(result: DrivenResult) -> str:
    """The page's text; nothing in it is loaded from elsewhere."""
    wrong, sure, do = sentences(result)
    name = escape(Path(result.driven.name).name)
    style = files("stillarm.diagnosis.report").joinpath("style.css").read_text()
    verdict = escape(str(result.table["verdict"]))
    driven = result.driven
    about = (
        f"{name}, {driven.duration_s:.1f} s at {1.0 / driven.step_s:g} Hz, driven by {driven.drive}; "
        f"stillarm {program_version()}"
    ) + unread(result.table)
    picture = curves(result)
    return (
        "<!doctype html>\n<html lang=en><head><meta charset=utf-8>"
        "<meta name=viewport content='width=device-width, initial-scale=1'>"
        f"<title>{name}: {verdict}</title><style>{style}</style></head><body><main>"
        f"<header><h1 class='{verdict}'>{escape(wrong)}</h1><p class=summary>{escape(sure)} {escape(do)}</p>"
        f"<p class=about>Diagnosis of {escape(about)}</p></header>"
        f"<h2>The force that is missing</h2><figure>{svg(picture)}</figure>"
        f"<h2>Findings</h2>{_findings(result.table)}<h2>Channels</h2>{_channels(result.table)}"
        f"{_recordings(result.table)}<h2>The joint as fitted</h2>{_start(result.table)}"
        "<footer>Written by <code>stillarm diagnose</code>. docs/measured-rigs.md tells how it decides; "
        "diagnosis.json holds the same numbers.</footer></main></body></html>\n"
    )


def _rows(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    top = "".join(f"<th>{escape(one)}</th>" for one in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(one)}</td>" for one in row) + "</tr>" for row in rows)
    return f"<div class=scroll><table><tr>{top}</tr>{body}</table></div>"


def _findings(table: dict[str, Any]) -> str:
    rows = []
    for one in table["findings"]:
        numbers = ", ".join(f"{n} = {v['value']:.4g} +- {v['std']:.2g}" for n, v in one["parameters"].items())
        gain = one["held_out"]["log_score_gain"]
        rows.append((one["cause"], one["form"], numbers, f"{one['confidence']:.2f}", f"{gain:.0f}"))
    return _rows(("cause", "form", "numbers (of theta'', in SI)", "confidence", "held-out nats"), rows)


def _channels(table: dict[str, Any]) -> str:
    rows = [
        (name, f"{one['nrmse_before']:.4f}", f"{one['nrmse_after']:.4f}", f"{one['noise_floor']:.4f}")
        for name, one in table["channels"].items()
    ]
    return _rows(("channel", "held-out error, linear", "with the causes", "noise"), rows)


def _recordings(table: dict[str, Any]) -> str:
    """Of several recordings of one rig: each foretold by the others, without and with the causes."""
    if "recordings" not in table:
        return ""
    rows = []
    for one in table["recordings"]:
        foretold = one["foretold_by_the_others"] or {}
        errors = ", ".join(
            f"{name} {each['nrmse_before']:.4f} to {each['nrmse_after']:.4f}"
            for name, each in foretold.items()
        )
        holds = [each["cause"] for each in table["findings"] if one["recording"] in each["holds_in"]]
        said = {None: "not proven", True: "worse", False: "not worse"}[one["worse"]]
        rows.append((one["recording"], ", ".join(holds) or "none", errors or "-", said))
    head = (
        "recording",
        "causes that hold there",
        "error foretold by the others, linear to extended",
        "extended model",
    )
    return f"<h2>Recordings</h2>{_rows(head, rows)}"


def _start(table: dict[str, Any]) -> str:
    rows = [(n, f"{v['value']:.5g}", f"{v['std']:.2g}") for n, v in table["start"]["numbers"].items()]
    return _rows(("number", "value", "std"), rows)
