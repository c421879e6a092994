"""The page: it stands alone, says the verdict, shows losses like gains, and escapes what it did not write."""

import re
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from importlib.resources import files
from typing import Any

import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from stillarm.commands.recordings.diagnose_result import sentence
from stillarm.common.causes import CAUSES as CATALOGUE
from stillarm.diagnosis.diagnose import diagnose_measured
from stillarm.diagnosis.forms.causes import CAUSES
from stillarm.diagnosis.report.drawing import _VARIABLES, AFTER, INK, SHADE, Picture, figure, svg
from stillarm.diagnosis.report.page import report_page
from stillarm.diagnosis.report.picture import _TELLING, main_picture
from stillarm.diagnosis.report.result import Result
from stillarm.diagnosis.report.sections import gains
from stillarm.diagnosis.report.sections import use as use_section
from stillarm.diagnosis.report.summary import summary
from stillarm.diagnosis.report.use import MEASURES
from stillarm.diagnosis.report.words import NAMES, next_steps, number, verdict_sentence
from tests.fixtures.synthetic import MODEL, measured


@pytest.fixture(scope="module")
def found() -> Result:
    """A joint with friction."""
    data = replace(measured(8.0, 3, {"drive.velocity_loss_rad_s": 0.01}), name="<b>rig & co.mcap")
    return diagnose_measured(data, MODEL)


@pytest.fixture(scope="module")
def page(found: Result) -> str:
    """Its page."""
    return report_page(found)


class _Tags(HTMLParser):
    """Counts what is opened and not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: set[str] = set()
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)
        self.links += [value or "" for key, value in attrs if key in ("src", "href", "xlink:href")]
        if tag not in ("meta", "br", "hr", "link", "img"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for key, value in attrs if key in ("src", "href", "xlink:href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_every_cause_has_a_name_and_a_picture() -> None:
    assert set(NAMES) == set(CATALOGUE)
    assert set(_TELLING) <= set(CATALOGUE)
    assert set(CAUSES) <= set(NAMES)


@pytest.mark.slow
def test_the_page_is_whole_and_loads_nothing(page: str) -> None:
    tags = _Tags()
    tags.feed(page)
    assert tags.open == []
    assert not tags.seen & {"script", "link", "img", "iframe", "object"}
    assert all(link.startswith("#") for link in tags.links)
    assert not re.search(r"url\((?!#)|@import", page)
    ids = re.findall(r'\bid="([^"]*)"', page)
    assert {link[1:] for link in tags.links} <= set(ids)


@pytest.mark.slow
def test_it_says_the_verdict_the_cause_and_what_else_was_considered(found: Result, page: str) -> None:
    assert found.table["findings"][0]["cause"] == "joint_friction"
    assert NAMES["joint_friction"] in page
    assert "What else was considered" in page
    for stage in found.found.stages:
        assert all(one.cause in page for one in stage.candidates[:8])
    assert "&lt;b&gt;rig &amp; co.mcap" in page
    assert "<b>rig" not in page


@pytest.mark.slow
def test_a_loss_is_shown_as_one(found: Result) -> None:
    channels = {name: dict(one) for name, one in found.table["channels"].items()}
    channels["acceleration"] |= {"nrmse_before": 0.10, "nrmse_after": 0.13}
    assert "<span class='worse'>+30.0 %</span>" in gains(
        replace(found, table={**found.table, "channels": channels})
    )


@pytest.mark.slow
def test_what_it_is_worth_in_use_is_told_where_it_is_known(found: Result) -> None:
    keys = tuple(MEASURES)
    use: dict[str, Any] = {
        "before": dict.fromkeys(keys, 0.2), "after": dict.fromkeys(keys, 0.3), "spread": None, "pairs": 1, "note": None,
    }  # fmt: skip
    section = use_section(replace(found, table={**found.table, "use": use}))
    assert "worth in use" in section
    assert "<span class='worse'>+50 %</span>" in section
    assert "prediction error while the joint moves 20.00 % to 30.00 %, worse; " in section
    assert "settling time 0.200 s to 0.300 s, worse; " in section
    assert use_section(found) == ""
    unsure = {**use, "spread": dict.fromkeys(keys, 0.06), "pairs": 4}
    section = use_section(replace(found, table={**found.table, "use": unsure}))
    assert "<span class=''>+50 %</span> ± 30 %" in section
    assert "by 4 pairs of runs: nothing is to be gained" in section


def test_figures_take_the_pages_colours() -> None:
    def draw(axes: Axes) -> None:
        axes.plot([0, 1], [1, 0], color=AFTER)

    one = Picture([draw], "a line")
    text = svg(one)
    assert "var(--after)" in text and "var(--ink)" in text
    assert AFTER not in text and INK not in text
    (axes,) = figure(one).axes
    assert axes.lines[0].get_color() == AFTER


def test_the_pages_colours_in_daylight_are_the_figures() -> None:
    """But for the shade, which the page draws through."""
    style = files("stillarm.diagnosis.report").joinpath("style.css").read_text().split("@media", 1)[0]
    for colour, variable in _VARIABLES.items():
        if colour != SHADE:
            assert f"{variable}: {colour};" in style


@pytest.mark.slow
def test_the_page_begins_with_three_sentences(found: Result, page: str) -> None:
    wrong, sure, do = (escape(one) for one in summary(found))
    body = page.split("<body>", 1)[1]
    assert re.match(rf"<main><header><h1 class='named'>{re.escape(wrong)}</h1>", body)
    assert f"<p class=summary>{sure} {do}</p>" in body.split("</header>", 1)[0]


@pytest.mark.slow
@pytest.mark.parametrize("verdict", ["named", "none", "unexplained"])
def test_the_main_picture_is_of_the_verdict(found: Result, verdict: str) -> None:
    left = {"channel": "acceleration", "band_hz": [2.0, 9.0], "dependence": "", "term": ""}
    result = replace(
        found,
        table={**found.table, "verdict": verdict, "unexplained": left if verdict == "unexplained" else None},
    )
    one = main_picture(result)
    assert ("joint_friction" in one.label) is (verdict == "named")
    assert len(figure(one).axes) == len(one.panels)


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (600.04, 3.2, "600.0 ± 3.2"),
        (0.0499321, 0.00017, "0.04993 ± 0.00017"),
        (1234.0, 160.0, "1230 ± 160"),
        (2.5, 0.0, "2.5"),
    ],
)
def test_numbers_have_the_digits_that_mean_something(value: float, std: float, text: str) -> None:
    assert number(value, std) == text


@pytest.mark.slow
def test_a_finding_that_what_is_left_dwarfs_is_not_put_forward(found: Result) -> None:
    """Its name comes after what has none, and the page does not send anybody to look for nothing wrong."""
    table = found.table
    unsure = [{**one, "confidence": 0.01} for one in table["findings"]]
    left = {
        "channel": "acceleration",
        "band_hz": [2.0, 9.0],
        "dependence": "nothing that was tried",
        "term": "",
    }
    doubtful = replace(
        found, table={**table, "verdict": "unexplained", "unexplained": left, "findings": unsure}
    )
    said = verdict_sentence(doubtful)
    assert said.startswith("The accelerometer holds structure") or said.startswith(
        "The acceleration holds structure"
    )
    assert "may be a small part of it" in said
    assert sentence(doubtful.table).startswith("acceleration holds structure")
    steps = " ".join(next_steps(doubtful))
    assert "nothing is wrong" not in steps and "alone varied" not in steps and "a mode" in steps
    assert "No term of the simulated state" in report_page(doubtful)
    sure = {**doubtful.table, "findings": [{**one, "confidence": 0.9} for one in unsure]}
    assert "may be a small part" not in verdict_sentence(replace(found, table=sure))


def test_a_factor_at_an_axis_does_not_lift_the_title_out_of_its_panel() -> None:
    def draw(axes: Axes) -> None:
        axes.plot([0.0, 1.0], [1e-4, 4e-4])
        axes.set_title("where the simulations differ most (held out)")

    drawn = figure(Picture([draw], "a picture"))
    FigureCanvasAgg(drawn).draw()
    (axes,) = drawn.axes
    assert axes.yaxis.get_offset_text().get_text()
    tops = [
        one.get_window_extent().y1 for one in axes.get_children() if isinstance(one, Text) and one.get_text()
    ]
    assert tops and max(tops) <= drawn.bbox.y1
