"""The panel in a real browser, on a demo in real time: it shows, operates, stops, and comes back.

Needs Debian's chromium and chromium-driver; without them one line says that it is skipped. One demo serves all
cases, in their order: the later ones kill what the earlier ones need.
"""

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from stillarm.common.link.free_ports import free_ports
from stillarm.common.process.child_process import next_line, start_module, stop_process
from stillarm.common.recording.reader import open_recording
from stillarm.simulation.demo.attended import attended_demo

webdriver = pytest.importorskip("selenium.webdriver", reason="no selenium: `pip install 'stillarm[dev]'`")
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
AXE = Path(__file__).parents[1] / "fixtures" / "axe" / "axe.min.js"
STANDS_S = 0.5  # a command that has been zero for so long stays zero
STARTS_WITHIN_S = 60.0  # the controller warms up, on a computer that may be busy
VIEWS = ("live", "recordings", "commission")

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(
        CHROMIUM is None or DRIVER is None, reason="no browser: `apt-get install chromium chromium-driver`"
    ),
]


class Page(NamedTuple):
    """browser: with the panel's page open. The rest is of the demo behind it."""

    browser: Any
    folder: Path
    process_ids: dict[str, int]
    panel: list[subprocess.Popen[bytes]]
    start_panel: Any
    stop_asked_s: list[float]

    def text(self, name: str) -> str:
        return str(self.browser.find_element("id", name).text)

    def click(self, selector: str) -> None:
        """A press of the mouse on its middle: chromedriver's own click waits for a page that never rests."""
        script = """const e = document.querySelector(arguments[0]); e.scrollIntoView({block: 'center'});
                    const r = e.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2];"""
        x, y = self.browser.execute_script(script, selector)
        for kind in ("mousePressed", "mouseReleased"):
            event = {"type": kind, "x": x, "y": y, "button": "left", "clickCount": 1}
            self.browser.execute_cdp_cmd("Input.dispatchMouseEvent", event)

    def operate(self, action: str, *, confirm: bool) -> None:
        self.click(f"[data-action={action}]")
        if confirm:
            self.until("document.getElementById('ask').open")
            self.click("#ask-yes")
        self.until("document.getElementById('action-told').textContent.endsWith('sent')")

    def state(self) -> str:
        return str(self.browser.execute_script("return document.getElementById('state').dataset.state"))

    def until(self, condition: str, within_s: float = 10.0) -> float:
        """Wait until an expression holds in the page; how long that took, s."""
        began = time.monotonic()
        while not self.browser.execute_script(f"return Boolean({condition})"):
            assert time.monotonic() < began + within_s, f"not within {within_s} s: {condition}"
            time.sleep(0.01)
        return time.monotonic() - began

    def monotonic_s(self, page_ms: str) -> float:
        """A time of the page's own clock on the monotonic clock, s: by the quickest of twenty looks at both."""
        looks = []
        for _ in range(20):
            began = time.monotonic()
            now_ms = float(self.browser.execute_script("return performance.now()"))
            ended = time.monotonic()
            looks.append((ended - began, (began + ended) / 2.0 - now_ms * 1e-3))
        return min(looks)[1] + float(self.browser.execute_script(f"return {page_ms}")) * 1e-3

    def amplitude_mm(self, seconds: float = 0.8) -> float:
        """The greatest deflection that the page shows beside its chart's title in that time."""
        script = """
            const done = arguments[1], end = performance.now() + 1000 * arguments[0]; let most = 0;
            const look = () => {
              const shown = document.querySelector('#live-charts output').textContent;
              most = Math.max(most, Math.abs(parseFloat(shown)) || 0);
              performance.now() < end ? requestAnimationFrame(look) : done(most);
            }; look();"""
        return float(self.browser.execute_async_script(script, seconds))

    def violations(self) -> list[str]:
        """What axe-core finds wrong with what is shown."""
        script = "const done = arguments[0]; axe.run().then((found) => done(found.violations));"
        found = self.browser.execute_async_script(script)
        return [f"{one['id']}: {[node['html'][:120] for node in one['nodes']]}" for one in found]


def browser(width: int = 1280, height: int = 720) -> Any:
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", f"--window-size={width},{height}"):
        options.add_argument(word)
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    folder = tmp_path_factory.mktemp("panel") / "demo"
    (port,) = free_ports(1)
    stop_asked_s: list[float] = []

    with attended_demo(folder, 3, lambda label: nullcontext(lambda done: None)) as demo:
        words = ("--config", str(demo.configuration), "--recordings", str(folder), "--port", str(port))

        def start_panel() -> tuple[subprocess.Popen[bytes], str]:
            panel = start_module("stillarm", "panel", *words, "--hold-damping", stdout=subprocess.PIPE)
            line = next_line(panel, 20.0)
            assert line is not None and line.startswith("stillarm panel: http://127.0.0.1")
            return panel, line.split()[-1]

        panel, address = start_panel()
        panels = [panel]
        shown = browser()
        try:
            shown.get(address)
            page = Page(shown, folder, demo.process_ids, panels, start_panel, stop_asked_s)
            page.until("document.getElementById('state').dataset.state === 'armed'", STARTS_WITHIN_S)
            yield page
        finally:
            shown.quit()
            for one in panels:
                stop_process(one, 5.0)
    if stop_asked_s:
        judge_stop(folder / "recording.mcap", stop_asked_s[0])


def judge_stop(path: Path, asked_s: float) -> None:
    """From the click, on the monotonic clock, to the command that stays zero: at most 0.2 s."""
    recording = open_recording(path)
    fast = recording.columns("/fast")
    times = fast["time_s"] + recording.header.origin_monotonic_s
    command = np.abs(fast["joint_velocity_command_rad_s"])
    before = command[(times > asked_s - 1.0) & (times < asked_s)]
    assert before.max() > 1e-3, "the joint stood still before the stop: nothing was stopped"
    moving = times[(command > 1e-9) & (times > asked_s)]
    pauses = np.flatnonzero(np.diff(moving) > STANDS_S)  # later it is armed again
    zero_s = moving[pauses[0] if pauses.size else -1] - asked_s
    assert zero_s <= 0.2, f"the command was zero {zero_s:.3f} s after the click"


def test_the_page_opens_and_its_charts_move(page: Page) -> None:
    page.until("Number(document.getElementById('age').dataset.ageMs) > 0")
    assert "#token" not in page.browser.current_url
    picture = "document.querySelector('#live-charts canvas').toDataURL()"
    before = page.browser.execute_script(f"return {picture}")
    page.until(f"{picture} !== {before!r}", 2.0)
    assert page.text("access") == "" and page.text("health").startswith("damping")
    page.until("document.getElementById('camera-view').hidden === false")
    errors = [line for line in page.browser.get_log("browser") if line["level"] == "SEVERE"]
    assert errors == []


def test_what_is_forbidden_says_why(page: Page) -> None:
    button = page.browser.find_element("css selector", "[data-action=arm]")
    assert button.get_attribute("aria-disabled") == "true"
    page.click("[data-action=arm]")
    assert page.text("action-told") == "Arm: armed already (state armed)"
    page.click("[data-action=clear]")
    assert page.text("action-told") == "Clear fault: there is no fault to clear"


def test_a_cancelled_question_moves_nothing(page: Page) -> None:
    page.click("[data-action=allow_damping]")
    page.until("document.getElementById('ask').open")
    page.click("#ask-no")
    page.until("document.getElementById('action-told').textContent.endsWith('cancelled')")
    assert page.state() == "armed"


def test_damping_is_allowed_by_a_click_and_the_amplitude_falls(page: Page) -> None:
    page.operate("strike", confirm=True)
    time.sleep(0.7)
    free_mm = page.amplitude_mm()
    assert free_mm > 2.0
    still_mm = page.amplitude_mm()
    assert still_mm > 0.6 * free_mm  # it rings
    page.operate("allow_damping", confirm=True)
    page.until("document.getElementById('state').dataset.state === 'damping'")
    time.sleep(2.0)
    assert page.amplitude_mm() < 0.25 * free_mm


def test_no_view_violates_the_accessibility_rules(page: Page) -> None:
    page.browser.execute_script(AXE.read_text(encoding="utf-8"))
    for scheme in ("light", "dark"):
        media = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
        for view in VIEWS:
            page.click(f"#tab-{view}")
            time.sleep(0.2)
            assert page.violations() == [], f"{view}, {scheme}"
    page.click("#tab-live")


def test_a_recording_is_opened_scrubbed_and_played(page: Page) -> None:
    page.click("#tab-recordings")
    page.until("document.querySelector('#rec-list button span')?.textContent.endsWith('.mcap')")
    names = [e.text for e in page.browser.find_elements("css selector", "#rec-list button span")]
    page.click(f"#rec-list li:nth-child({names.index('recording.mcap') + 1}) button")
    page.until("!document.getElementById('rec-play').disabled")
    shown = "document.getElementById('rec-time-told').textContent"
    slide = """const bar = document.getElementById('rec-time'); bar.value = 2.5;
               bar.dispatchEvent(new Event('input', {bubbles: true}));"""
    page.browser.execute_script(slide)
    assert page.text("rec-time-told") == "2.50 s"
    page.until("document.querySelector('#rec-charts output').textContent !== '-'")
    page.click("#rec-play")
    page.until(f"parseFloat({shown}) > 2.8", 3.0)
    page.click("#rec-play")
    page.browser.execute_script(AXE.read_text(encoding="utf-8"))
    assert page.violations() == []
    page.click("#tab-live")


def test_a_page_without_the_token_only_looks(page: Page) -> None:
    cookie = page.browser.get_cookie("stillarm_panel")
    assert cookie["httpOnly"] and cookie["sameSite"] == "Strict"
    page.browser.delete_all_cookies()
    page.browser.refresh()
    page.until("document.getElementById('access').textContent.startsWith('read-only')")
    assert page.browser.find_element("id", "stop").get_attribute("aria-disabled") == "true"
    page.click("#stop")
    assert "read-only" in page.text("action-told")
    assert page.state() in {"armed", "damping"}
    page.browser.add_cookie({k: cookie[k] for k in ("name", "value", "path")})
    page.browser.refresh()
    page.until("document.querySelector('[data-action=disarm]')?.getAttribute('aria-disabled') === 'false'")


def test_the_stop_key_stops_at_once(page: Page) -> None:
    """The fixture's end judges the recording: at most 0.2 s from the key to the command that stays zero."""
    page.operate("strike", confirm=True)
    time.sleep(0.3)
    from selenium.webdriver.common.keys import Keys

    script = (
        "addEventListener('keydown', (event) => { window.pressedMs = event.timeStamp; }, {capture: true});"
    )
    page.browser.execute_script(script)
    page.browser.switch_to.active_element.send_keys(Keys.ESCAPE)
    page.until("document.getElementById('state').dataset.state === 'fault'", 5.0)
    page.stop_asked_s.append(page.monotonic_s("window.pressedMs"))
    assert "emergency stop" in page.text("state")


def test_after_a_stop_clear_and_arm_are_asked_for(page: Page) -> None:
    page.operate("clear", confirm=True)
    page.until("document.getElementById('state').dataset.state === 'idle'")
    page.operate("arm", confirm=True)
    page.until("['armed', 'damping'].includes(document.getElementById('state').dataset.state)")
    page.operate("disarm", confirm=False)
    page.until("document.getElementById('state').dataset.state === 'idle'")
    page.operate("arm", confirm=True)
    page.until("['armed', 'damping'].includes(document.getElementById('state').dataset.state)")


def test_a_killed_supervisor_shows_within_half_a_second(page: Page) -> None:
    os.kill(page.process_ids["supervisor"], signal.SIGKILL)
    assert page.until("document.getElementById('state').dataset.state === 'degraded'", 3.0) <= 0.5
    assert "no image" in page.text("state")


def test_a_restarted_server_is_found_again(page: Page) -> None:
    stop_process(page.panel.pop(), 5.0)
    page.until("document.getElementById('state-word').textContent === 'No connection'", 3.0)
    page.panel.append(page.start_panel()[0])
    page.until("document.getElementById('state').dataset.state === 'degraded'", 5.0)
