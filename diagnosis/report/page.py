"""report.html: one page that stands alone, readable on paper and in dark mode."""

from collections.abc import Callable
from html import escape
from importlib.resources import files
from pathlib import Path

from stillarm.common.recording.header import program_version
from stillarm.diagnosis.report import sections
from stillarm.diagnosis.report.result import Result
from stillarm.diagnosis.report.summary import summary
from stillarm.diagnosis.report.words import unread


def report_page(result: Result, await_use: Callable[[], None] = lambda: None) -> str:
    """The page's text; nothing in it is loaded from elsewhere.

    await_use: called last, before what `stillarm.diagnosis.report.use` adds to the result's table is read.
    """
    measured = result.found.final.world.measured
    name = Path(measured.name).name
    style = files("stillarm.diagnosis.report").joinpath("style.css").read_text()
    held = sum(
        float(end - start)
        for start, end, out in zip(
            result.split.edges_s[:-1], result.split.edges_s[1:], result.split.held, strict=True
        )
        if out
    )
    about = (
        f"{name}, {measured.duration_s:.1f} s at {1.0 / measured.cycle_s:g} Hz, {len(measured.frames)} frames; "
        f"{held:.1f} s of it held out of every fit; stillarm {program_version()}"
    ) + unread(result.table)
    head = sections.findings(result) + sections.gains(result)
    tail = "".join(
        each(result)
        for each in (sections.what_next, sections.baseline, sections.considered, sections.residuals)
    )
    await_use()
    body = head + sections.use(result) + tail
    verdict = str(result.table["verdict"])
    wrong, sure, do = summary(result)
    return (
        "<!doctype html>\n<html lang=en><head><meta charset=utf-8>"
        "<meta name=viewport content='width=device-width, initial-scale=1'>"
        f"<title>{escape(name)}: {escape(verdict)}</title><style>{style}</style></head><body><main>"
        f"<header><h1 class='{escape(verdict)}'>{escape(wrong)}</h1>"
        f"<p class=summary>{escape(sure)} {escape(do)}</p>"
        f"<p class=about>Diagnosis of {escape(about)}</p></header>{body}"
        "<footer>Written by <code>stillarm diagnose</code>. docs/diagnosis.md tells how it decides; "
        "diagnosis.json holds the same numbers; extended.toml the model.</footer></main></body></html>\n"
    )
