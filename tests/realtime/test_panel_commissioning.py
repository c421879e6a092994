"""Commissioning from the page, once from start to end: the check, the moves on the simulated rig, the model.

Needs Debian's chromium and chromium-driver, as test_panel_in_browser.py does. It takes three to four minutes.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest

from stillarm.common.files.model import load_model
from stillarm.common.process.child_process import stop_process
from stillarm.common.recording.reader import open_recording
from tests.fixtures.quiet_rig import quiet_rig
from tests.fixtures.shown_page import (
    AXE,
    NEEDS_BROWSER,
    ShownPage,
    opened_browser,
    start_panel,
)

pytest.importorskip("selenium.webdriver", reason="no selenium: `pip install 'stillarm[dev]'`")
LASTS_AT_MOST_S = 420.0  # the moves last 90 s; the fit, on a busy computer, longer
TRUE_FREQUENCY_HZ = 2.6  # of the demo's rig

pytestmark = [pytest.mark.realtime, NEEDS_BROWSER]


@pytest.fixture
def shown(tmp_path: Path) -> Iterator[tuple[ShownPage, Path]]:
    """The commissioning view, and the panel's folder."""
    with quiet_rig(tmp_path) as configuration:
        recordings = tmp_path / "recordings"
        recordings.mkdir()
        words = ("--config", str(configuration), "--recordings", str(recordings), "--port", "0")
        panel, address = start_panel(*words)
        try:
            with opened_browser() as browser:
                browser.get(address)
                page = ShownPage(browser)
                page.until("document.getElementById('steps').children.length === 0")
                page.click("#tab-commission")
                page.until("document.getElementById('steps').children.length === 5")
                yield page, recordings
        finally:
            stop_process(panel, 20.0)


@pytest.mark.blind(each_run=2, group="long runs of the real processes")
def test_a_rig_is_commissioned_from_the_page(shown: tuple[ShownPage, Path]) -> None:
    page, recordings = shown
    told = "document.getElementById('commission-told').textContent"
    lines = "document.getElementById('commission-lines').textContent"
    page.click("#check")
    page.until(f"/camera.*drive|drive.*camera/s.test({lines})", 60.0)
    assert page.browser.execute_script("return document.getElementById('commission-stop').disabled")

    page.click("#commission")
    page.until("document.getElementById('ask').open")
    assert "At most" in page.text("ask-text") and "Is the arm free to move?" in page.text("ask-text")
    page.click("#ask-no")
    page.until("!document.getElementById('ask').open")
    assert not (recordings / "commissioning").exists()  # nothing has moved

    page.until("!document.getElementById('check').disabled")
    page.click("#commission")
    page.until("document.getElementById('ask').open")
    page.click("#ask-yes")
    page.until("document.getElementById('commission-stop').disabled === false", 20.0)
    page.until("document.getElementById('commission-progress').value > 0.05", 60.0)
    page.click("#tab-live")  # the moves are seen, and the emergency stop is in reach
    page.until("['armed', 'idle'].includes(document.getElementById('state').dataset.state)", 60.0)
    page.click("#tab-commission")
    page.until(f"{told} !== ''", LASTS_AT_MOST_S)
    said = page.browser.execute_script(f"return {lines}")
    if "no image was measured" in said:
        pytest.skip("this machine is too busy to track images")
    assert page.browser.execute_script(f"return {told}").startswith("Go: name commissioned_model.toml"), said

    page.until("document.getElementById('commission-picture').naturalWidth > 300")
    model = load_model(recordings / "commissioned_model.toml")
    assert model.identified
    assert model.arm.modes[0].frequency_hz == pytest.approx(TRUE_FREQUENCY_HZ, rel=0.01)
    moved = open_recording(recordings / "commissioning" / "moves.mcap").columns("/fast")
    assert abs(moved["joint_velocity_command_rad_s"]).max() > 0.003
    page.browser.execute_script(AXE.read_text(encoding="utf-8"))
    assert page.violations() == []
