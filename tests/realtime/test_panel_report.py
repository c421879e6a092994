"""A diagnosis from the page, without a rig: its report passes axe-core, and leaves Stop within reach.

Needs Debian's chromium and chromium-driver, as test_panel_in_browser.py does.
"""

from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
import tomli_w

import stillarm
from stillarm.common.files.scenario import Scenario, Strike
from stillarm.common.link.free_ports import free_ports
from stillarm.common.process.child_process import stop_process
from stillarm.simulation.demo.hidden_effect import revealing_moves
from stillarm.simulation.demo.set_up import STRUCK_M, write_demo_configuration
from tests.fixtures.imports import ROOT
from tests.fixtures.shown_page import AXE, NEEDS_BROWSER, ShownPage, opened_browser, start_panel

pytest.importorskip("selenium.webdriver", reason="no selenium: `pip install 'stillarm[dev]'`")
LASTS_S = 12.0  # the recording: several moves, so that friction shows
DIAGNOSED_WITHIN_S = 300.0  # on a busy computer; the first compiles
FRAME = "document.getElementById('report-frame')"
TOLD = "document.getElementById('action-told').textContent"
ASKED = f"{TOLD}.startsWith('Stop: no controller answers')"  # it was sent, and nobody is there
OPEN = "document.getElementById('report-dialog').open"

pytestmark = [pytest.mark.realtime, NEEDS_BROWSER]


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ShownPage]:
    """The report of a recording with friction, in the page of a panel that hears no controller."""
    folder = tmp_path_factory.mktemp("report")
    path, configuration, _ = write_demo_configuration(folder, LASTS_S, 4)
    telemetry = msgspec.structs.replace(configuration.telemetry, panel_port=free_ports(1)[0])
    configuration = msgspec.structs.replace(configuration, telemetry=telemetry)
    path.write_text(tomli_w.dumps(msgspec.to_builtins(configuration)))
    recordings = folder / "recordings"
    recordings.mkdir()
    known = stillarm.Model.read(ROOT / "configs" / "model.toml")
    friction = {"cause": "joint_friction", "velocity_loss_rad_s": 0.006}
    moves = revealing_moves(3.0, LASTS_S)
    scenario = Scenario(duration_s=LASTS_S, moves=moves, strikes=[Strike(1.0, STRUCK_M)])
    told = folder / "moves.toml"
    told.write_text(tomli_w.dumps(msgspec.to_builtins(scenario)))
    run = stillarm.simulate(msgspec.structs.replace(known, effects=[friction]), told, 3, assumed=known)
    Path(run.recording.path).rename(recordings / "friction.mcap")
    panel, address = start_panel("--config", str(path), "--recordings", str(recordings), "--port", "0")
    try:
        with opened_browser() as browser:
            browser.get(address)
            shown = ShownPage(browser)
            shown.open_recording("friction.mcap")
            shown.until("!document.getElementById('rec-play').disabled", 60.0)
            shown.click("#rec-diagnose")
            shown.until("document.getElementById('rec-progress').value > 0.02", 120.0)
            shown.until(OPEN, DIAGNOSED_WITHIN_S)
            yield shown
    finally:
        stop_process(panel, 20.0)


@pytest.fixture(autouse=True)
def report(page: ShownPage) -> None:
    """The report is open, and nothing has been asked for."""
    if not page.browser.execute_script(f"return {OPEN}"):
        page.click("#rec-report")
    page.until(f"{OPEN} && {FRAME}.contentDocument.querySelector('main')")
    page.browser.execute_script(f"{TOLD} = ''")


def test_the_report_and_its_frame_pass_the_accessibility_rules(page: ShownPage, tmp_path: Path) -> None:
    """The frame may run no script, so its text is judged as a page of its own, and the dialog in the panel's."""
    page.browser.execute_script(AXE.read_text(encoding="utf-8"))
    text = page.browser.execute_script(f"return {FRAME}.contentDocument.documentElement.outerHTML")
    assert "friction" in text
    alone = tmp_path / "report.html"
    alone.write_text(f"<!doctype html>{text}", encoding="utf-8")
    panel = page.browser.current_window_handle
    found = {}
    for scheme in ("light", "dark"):
        page.look(1280, 720, scheme)
        page.keep(f"report-{scheme}")
        found[f"dialog, {scheme}"] = page.violations("iframes: false")
        page.browser.switch_to.new_window("tab")
        try:
            page.browser.get(alone.as_uri())
            page.look(1280, 720, scheme)
            page.browser.execute_script(AXE.read_text(encoding="utf-8"))
            found[f"report, {scheme}"] = page.violations()
        finally:
            page.browser.close()
            page.browser.switch_to.window(panel)
    assert not any(found.values()), found


def test_the_reports_stop_stops(page: ShownPage) -> None:
    page.click("#report-dialog .stop")
    page.until(f"{ASKED} && !{OPEN}")


def test_escape_stops_where_the_report_has_the_keys(page: ShownPage) -> None:
    from selenium.webdriver.common.keys import Keys

    page.click("#report-frame")
    page.until(f"document.activeElement === {FRAME}")
    page.browser.switch_to.frame("report-frame")
    page.browser.switch_to.active_element.send_keys(Keys.ESCAPE)
    page.browser.switch_to.default_content()
    page.until(f"{ASKED} && !{OPEN}")


def test_escape_stops_where_a_list_of_choices_has_the_keys(page: ShownPage) -> None:
    """An open list keeps the press to itself; what comes through is the release."""
    from selenium.webdriver.common.keys import Keys

    page.click("#report-close")
    page.browser.execute_script("document.getElementById('rec-speed').focus()")
    page.browser.switch_to.active_element.send_keys(Keys.ALT, Keys.ARROW_DOWN)
    page.until("document.querySelector('#rec-speed').matches(':open')")
    for kind in ("rawKeyDown", "keyUp"):
        key = {"type": kind, "key": "Escape", "code": "Escape", "windowsVirtualKeyCode": 27}
        page.browser.execute_cdp_cmd("Input.dispatchKeyEvent", key)
    page.until(ASKED)


def test_the_frame_runs_no_script_and_loads_nothing(page: ShownPage) -> None:
    script = f"""const made = {FRAME}.contentDocument.createElement('script');
                 made.textContent = 'parent.ran = true'; {FRAME}.contentDocument.body.append(made);
                 return window.ran === undefined;"""
    assert page.browser.execute_script(script)
