"""The panel in a real browser, on a demo in real time: it shows, operates, stops, and comes back.

Needs Debian's chromium and chromium-driver; without them one line says that it is skipped. One demo serves all
cases. Each brings the page and the arm to where it begins, whatever became of the case before it; only what kills a
process comes last.
"""

import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stillarm.common.files.configuration import Configuration, load_configuration
from stillarm.common.link.free_ports import free_ports
from stillarm.common.process.child_process import stop_process
from stillarm.common.recording.reader import open_recording
from stillarm.controller.replay.replay import compare_with_live, read_run
from stillarm.simulation.demo.attended import attended_demo
from stillarm.simulation.rig.strike_requests import request_strike
from tests.fixtures.recordings import some_fast, written
from tests.fixtures.shown_page import (
    AXE,
    NEEDS_BROWSER,
    SAMPLES_WITHIN_S,
    ShownPage,
    opened_browser,
    start_panel,
)
from tests.fixtures.tracked_images import PERIOD_S, READ_LATER_S, frames_of, tracked_images

pytest.importorskip("selenium.webdriver", reason="no selenium: `pip install 'stillarm[dev]'`")
# zero for over half a swing is no damping; after a stop the page arms again within half a second
STANDS_S = 0.25
SWING_S = 0.5  # the arm's first mode swings once within it
STRUCK_EVERY_S = 0.4
STRUCK_MM, STILL_MM = 2.0, 0.5  # a strike makes some 5 mm
MOVES_RAD_S = 1e-3
HEARD = "!['', 'silent', 'unheard', 'unknown'].includes(document.getElementById('state').dataset.state)"
BESIDE_WITHIN_S = 3.0  # behind the newest sample: twice what may wait for a process of lower priority
WINDOW_S = 10.0  # that the page shows at first
STARTS_WITHIN_S = 60.0  # the controller warms up, on a computer that may be busy
SCREENS = ((1280, 720), (1920, 1080), (820, 1180))
VIEWS = ("live", "recordings", "commission")

pytestmark = [pytest.mark.realtime, NEEDS_BROWSER]


class Page(ShownPage):
    """The panel's page, and the demo behind it."""

    def __init__(
        self, browser: Any, process_ids: dict[str, int], configuration: Configuration, words: tuple[str, ...]
    ) -> None:
        super().__init__(browser)
        self.process_ids, self.configuration, self._words = process_ids, configuration, words
        self.panel, self.address = start_panel(*words)
        self.stop_asked_s: list[float] = []
        self.adjusted: list[tuple[str, float]] = []
        self.session: dict[str, str] = {}

    def restart_panel(self) -> None:
        self.panel, _ = start_panel(*self._words)

    def begin(self) -> None:
        """Show the live view of a page that may operate, whatever was left open."""
        if self.session and self.browser.get_cookie("stillarm_panel") is None:
            self.browser.add_cookie(self.session)
            self.browser.refresh()
        close = "document.querySelectorAll('dialog[open]').forEach((dialog) => dialog.close(''))"
        self.browser.execute_script(close)
        alone = "document.querySelectorAll('#beside-methods :checked').forEach((box) => box.click())"
        self.browser.execute_script(alone)
        self.look(*SCREENS[0], "light")
        self.click("#tab-live")

    def bring(self, *, damping: bool) -> None:
        """Bring the arm to damping, or to armed with the damping held."""
        self.until("document.querySelector('[data-action=arm]')")
        self.until(HEARD)
        if self.state() == "fault":
            self.operate("clear", confirm=True)
            self.until("document.getElementById('state').dataset.state === 'idle'")
        if self.state() == "idle":
            self.operate("arm", confirm=True)
            self.until("['armed', 'damping'].includes(document.getElementById('state').dataset.state)")
        action, wanted = ("allow_damping", "damping") if damping else ("hold_damping", "armed")
        if self.possible(action):
            self.operate(action, confirm=damping)
        self.until(f"document.getElementById('state').dataset.state === '{wanted}'")

    def possible(self, action: str) -> bool:
        button = self.browser.find_element("css selector", f"[data-action={action}]")
        return bool(button.get_attribute("aria-disabled") == "false")

    def still(self) -> None:
        """Damp until the arm is still."""
        self.bring(damping=True)
        self.await_amplitude(lambda most_mm: most_mm < STILL_MM)

    def await_command(self) -> None:
        """Wait until the joint is moved."""
        column = "live.topics.fast.valueAt('joint_velocity_command_rad_s', live.newest())"
        script = f'import("/page/main.js").then(({{live}}) => arguments[0](Math.abs({column})));'
        began = time.monotonic()
        while self.browser.execute_async_script(script) < MOVES_RAD_S:
            told = f"the joint stays still; {self.text('state')}; {self.text('health')}"
            assert time.monotonic() < began + SAMPLES_WITHIN_S, told

    def lag_s(self, method: str) -> float | None:
        """By how much a method beside lies behind the newest sample, s; None where it has none."""
        script = """const [method, done] = arguments; import("/page/main.js").then(({live}) =>
                    done(live.newest() - (live.beside.samples.get(method)?.newest() ?? NaN)));"""
        found = self.browser.execute_async_script(script, method)
        return None if found is None else float(found)

    def await_amplitude(self, holds: Callable[[float], bool]) -> None:
        began = time.monotonic()
        while not holds(most_mm := self.amplitude_mm(self.newest_s(), SWING_S)):
            told = f"the amplitude stays at {most_mm:.2f} mm; {self.text('state')}; {self.text('health')}"
            assert time.monotonic() < began + SAMPLES_WITHIN_S, told

    def strike(self) -> float:
        """Strike the arm by the page's button; the time at which it is deflected, s on the controller's clock.

        Looked for among all samples since before the strike: on a busy computer the newest ones are of an arm that
        has come to rest again.
        """
        before_s, began = self.newest_s(), time.monotonic()
        self.operate("strike", confirm=True)
        from_s = before_s
        while self.amplitude_mm(from_s, SWING_S) <= STRUCK_MM:
            told = f"no strike is seen; {self.text('state')}; {self.text('health')}"
            assert time.monotonic() < began + SAMPLES_WITHIN_S, told
            from_s += SWING_S / 2.0
        return from_s


@contextmanager
def struck_again_and_again(configuration: Configuration) -> Iterator[None]:
    """Keep the joint moving: a damped arm is still within a second, sooner than a busy computer's page is read."""
    enough = threading.Event()

    def strike() -> None:
        while not enough.wait(STRUCK_EVERY_S):
            request_strike(configuration)

    hammer = threading.Thread(target=strike)
    hammer.start()
    try:
        yield
    finally:
        enough.set()
        hammer.join()


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    folder = tmp_path_factory.mktemp("panel") / "demo"
    (port,) = free_ports(1)
    with attended_demo(folder, 3, lambda label: nullcontext(lambda done: None)) as demo:
        images = tracked_images()
        (folder / "images.mcap").write_bytes(written([("/images", one) for one in images]))
        (folder / "run.mcap").write_bytes(written([*some_fast(300), *frames_of(images)]))
        words = ("--config", str(demo.configuration), "--recordings", str(folder), "--port", str(port))
        with opened_browser() as browser:
            configuration = load_configuration(demo.configuration)
            page = Page(browser, demo.process_ids, configuration, (*words, "--hold-damping"))
            try:
                browser.get(page.address)
                page.until("document.getElementById('state').dataset.state === 'armed'", STARTS_WITHIN_S)
                cookie = browser.get_cookie("stillarm_panel")
                page.session = {key: cookie[key] for key in ("name", "value", "path")}
                yield page
            finally:
                stop_process(page.panel, 5.0)
    for asked_s in page.stop_asked_s:
        judge_stop(folder / "recording.mcap", asked_s)
    if page.adjusted:
        judge_adjustments(folder / "recording.mcap", page.adjusted)


@pytest.fixture(autouse=True)
def begun(page: Page) -> None:
    page.begin()


def judge_stop(path: Path, asked_s: float) -> None:
    """From the click, on the monotonic clock, to the command that stays zero: at most 0.2 s."""
    recording = open_recording(path)
    fast = recording.columns("/fast")
    times = fast["time_s"] + recording.header.origin_monotonic_s
    command = np.abs(fast["joint_velocity_command_rad_s"])
    before = command[(times > asked_s - 1.0) & (times < asked_s)]
    assert before.max() > MOVES_RAD_S, "the joint stood still before the stop: nothing was stopped"
    moving = times[(command > 1e-9) & (times > asked_s)]
    pauses = np.flatnonzero(np.diff(moving) > STANDS_S)  # later it is armed again
    zero_s = moving[pauses[0] if pauses.size else -1] - asked_s
    assert zero_s <= 0.2, f"the command was zero {zero_s:.3f} s after the click"


def judge_adjustments(path: Path, adjusted: list[tuple[str, float]]) -> None:
    """The recording holds what was adjusted from the page, and the replay obeys it, to the last bit."""
    recording = open_recording(path)
    told = [
        (row.method, row.added_damping_ratio)
        for row in recording.messages("/settings")
        if row.asked_method or not np.isnan(row.asked_added_damping_ratio)
    ]
    assert told == adjusted
    if lost := max((row.recorder_lost for row in recording.messages("/link")), default=0):
        warnings.warn(f"not replayed: the busy computer's recording lacks {lost} messages", stacklevel=2)
        return
    compared = compare_with_live(read_run(recording))
    assert compared.identical, compared.first_difference


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
    page.bring(damping=False)
    button = page.browser.find_element("css selector", "[data-action=arm]")
    assert button.get_attribute("aria-disabled") == "true"
    page.click("[data-action=arm]")
    assert page.text("action-told") == "Arm: armed already (state armed)"
    page.click("[data-action=clear]")
    assert page.text("action-told") == "Clear fault: there is no fault to clear"


def test_a_cancelled_question_moves_nothing(page: Page) -> None:
    page.bring(damping=False)
    page.click("[data-action=allow_damping]")
    page.until("document.getElementById('ask').open")
    page.click("#ask-no")
    page.until("document.getElementById('action-told').textContent.endsWith('cancelled')")
    assert page.state() == "armed"


def test_damping_is_allowed_by_a_click_and_the_amplitude_falls(page: Page) -> None:
    page.still()
    page.bring(damping=False)
    struck_s = page.strike() + SWING_S
    free_mm, later_mm = page.amplitude_mm(struck_s), page.amplitude_mm(struck_s + 0.8)
    assert later_mm > 0.6 * free_mm  # it rings
    page.operate("allow_damping", confirm=True)
    page.until("document.getElementById('state').dataset.state === 'damping'")
    assert page.amplitude_mm(page.newest_s() + 2.0) < 0.25 * free_mm


def test_what_is_seen_is_saved(page: Page) -> None:
    page.amplitude_mm(page.newest_s() + WINDOW_S, 0.0)  # waits: as long as a window has been seen
    page.click("#live-pause")
    head, *rows = page.saved("#live-csv").decode().splitlines()
    names = head.split(",")
    assert {"time_s", "acceleration_m_s2", "deflection_m", "damping_rad_s"} <= set(names)
    times = np.array([float(row.split(",")[0]) for row in rows])
    assert abs(times[-1] - times[0] - WINDOW_S) < 0.01
    assert np.median(np.diff(times)) == pytest.approx(1e-3), "every cycle is there"
    deflections = [float(row.split(",")[names.index("deflection_m")] or "nan") for row in rows]
    shown = page.amplitude_mm(float(times[0]), float(times[-1] - times[0]))
    assert 1e3 * np.nanmax(np.abs(deflections)) == pytest.approx(shown, rel=1e-6)
    assert page.saved("#live-png").startswith(b"\x89PNG")
    page.click("#live-pause")


def test_every_method_is_drawn_beside_the_one_in_force_on_request(page: Page) -> None:
    page.bring(damping=True)
    box = page.browser.find_element("css selector", "#beside-methods [data-method=fused]")
    page.until("document.querySelector('#beside-methods').textContent.includes('fused, in force')")
    others = ("timestamps", "kalman_fusion")
    assert box.is_displayed() and page.lag_s("timestamps") is None
    for method in others:
        page.click(f"#beside-methods [data-method={method}]")
    began = time.monotonic()
    while any((lag_s := page.lag_s(method)) is None or lag_s > BESIDE_WITHIN_S for method in others):
        assert time.monotonic() < began + SAMPLES_WITHIN_S, "no samples of the methods beside"
        time.sleep(0.05)
    titles = "[...document.querySelectorAll('#live-charts h2')].map((one) => one.textContent)"
    drawn = page.browser.execute_script(f"return {titles}.map((one) => one.includes('timestamps'))")
    assert drawn == [True, False, True, False]
    page.pause(3.0)
    page.keep("live-beside")
    head, *_ = page.saved("#live-csv").decode().splitlines()
    assert {"timestamps_deflection_m", "kalman_fusion_delay_s"} <= set(head.split(","))
    for method in others:
        page.click(f"#beside-methods [data-method={method}]")
    assert page.lag_s("timestamps") is None


def test_a_gain_changes_while_damping_and_a_method_only_while_not(page: Page) -> None:
    asked = "document.getElementById('ask').open"
    adjusted: list[tuple[str, float]] = []
    page.bring(damping=True)
    page.click("[data-action=adjust]")
    page.until("document.getElementById('adjust').open && document.getElementById('adjust-method').disabled")
    assert "state is damping; hold the damping, or disarm, first" in page.text("adjust-method-why")
    assert page.text("adjust-gain-why") == "from 0 to 0.2"
    page.browser.execute_script("document.getElementById('adjust-gain').value = '0.05'")
    page.click("#adjust-go")
    page.until(asked)
    assert "0.120 becomes 0.050" in page.text("ask-text")
    page.click("#ask-yes")
    page.until("document.getElementById('action-told').textContent === 'Method, gain: in force'")
    adjusted.append(("fused", 0.05))
    page.operate("hold_damping", confirm=False)
    page.until("document.getElementById('state').dataset.state === 'armed'")
    for method in ("timestamps", "fused"):
        page.click("[data-action=adjust]")
        page.until("document.getElementById('adjust').open")
        page.browser.execute_script(f"document.getElementById('adjust-method').value = '{method}'")
        if method == "fused":
            page.browser.execute_script("document.getElementById('adjust-gain').value = '0.12'")
        page.click("#adjust-go")
        page.until(asked)
        page.browser.execute_script("document.getElementById('action-told').textContent = ''")
        page.click("#ask-yes")
        page.until("document.getElementById('action-told').textContent === 'Method, gain: in force'")
        adjusted.append((method, 0.12 if method == "fused" else 0.05))
        page.until(f"document.getElementById('health').innerText.includes('method\\n{method}')")
    # for the fixture's end to judge; a case that failed halfway leaves nothing to judge
    page.adjusted = adjusted


def test_no_view_violates_the_accessibility_rules(page: Page) -> None:
    page.browser.execute_script(AXE.read_text(encoding="utf-8"))
    for scheme in ("light", "dark"):
        page.look(*SCREENS[0], scheme)
        for view in VIEWS:
            page.click(f"#tab-{view}")
            time.sleep(0.2)
            assert page.violations() == [], f"{view}, {scheme}"
    page.click("#tab-live")


def test_no_question_violates_the_accessibility_rules(page: Page) -> None:
    page.bring(damping=False)
    page.browser.execute_script(AXE.read_text(encoding="utf-8"))
    for scheme in ("light", "dark"):
        page.look(*SCREENS[0], scheme)
        for action, dialog, answer in (("strike", "ask", "ask-no"), ("adjust", "adjust", "adjust-cancel")):
            page.click(f"[data-action={action}]")
            page.until(f"document.getElementById('{dialog}').open")
            assert page.violations() == [], f"{dialog}, {scheme}"
            page.click(f"#{answer}")
            page.until(f"!document.getElementById('{dialog}').open")


def test_every_view_fits_a_small_screen_a_large_one_and_a_tablet(page: Page) -> None:
    """Nothing scrolls sideways, and the stop button is in view; STILLARM_SCREENSHOTS=DIR keeps what is seen."""
    fits = """const stop = document.getElementById('stop').getBoundingClientRect();
              return document.documentElement.scrollWidth <= innerWidth
                && stop.left >= 0 && stop.right <= innerWidth && stop.top >= 0 && stop.bottom <= innerHeight;"""
    for width, height in SCREENS:
        for scheme in ("light", "dark"):
            page.look(width, height, scheme)
            for view in VIEWS:
                page.click(f"#tab-{view}")
                time.sleep(0.3)
                page.keep(f"{view}-{width}x{height}-{scheme}")
                assert page.browser.execute_script(fits), f"{view} at {width}x{height}"
    page.look(*SCREENS[0], "light")
    page.click("#tab-live")


def test_a_recording_is_opened_scrubbed_and_played(page: Page) -> None:
    page.open_recording("recording.mcap")
    page.until("!document.getElementById('rec-play').disabled")
    shown = "document.getElementById('rec-time-told').textContent"
    page.seek(2.5)
    assert page.text("rec-time-told") == "2.50 s"
    page.until("document.querySelector('#rec-charts output').textContent !== '-'")
    page.click("#rec-play")
    page.until(f"parseFloat({shown}) > 2.8", 3.0)
    page.click("#rec-play")
    page.browser.execute_script(AXE.read_text(encoding="utf-8"))
    assert page.violations() == []
    page.click("#tab-live")


def test_recorded_images_follow_the_cursor_and_the_play(page: Page) -> None:
    page.open_recording("run.mcap")
    frame = "document.getElementById('rec-view').dataset.frame"
    picture = "document.getElementById('rec-view').toDataURL()"
    page.until(f"{frame} === '0'", 30.0)  # the images are looked for, and tracked again
    first = page.browser.execute_script(f"return {picture}")
    page.seek(READ_LATER_S + 5.5 * PERIOD_S)
    page.until(f"{frame} === '5' && {picture} !== {first!r}", 2.0)
    assert page.text("rec-view-told") == f"frame 5, read at {READ_LATER_S + 5 * PERIOD_S:.3f} s"
    page.browser.execute_script("document.getElementById('rec-speed').value = '0.1'")
    page.click("#rec-play")
    page.until(f"Number({frame}) > 7", 3.0)
    page.click("#rec-play")
    page.open_recording("images.mcap")  # the supervisor's own file: images, and what was tracked in them
    page.until("document.querySelector('#rec-charts .chart h2').textContent.startsWith('Image displacement')")
    page.until(f"{frame} === '0'", 30.0)
    page.click("#tab-live")


def test_a_page_without_the_token_only_looks(page: Page) -> None:
    page.bring(damping=True)
    cookie = page.browser.get_cookie("stillarm_panel")
    assert cookie["httpOnly"] and cookie["sameSite"] == "Strict"
    page.browser.delete_all_cookies()
    page.browser.refresh()
    page.until("document.getElementById('access').textContent.startsWith('read-only')")
    assert page.browser.find_element("id", "stop").get_attribute("aria-disabled") == "true"
    page.click("#stop")
    assert "read-only" in page.text("action-told")
    assert page.state() in {"armed", "damping"}
    page.browser.add_cookie(page.session)
    page.browser.refresh()
    page.until("document.querySelector('[data-action=disarm]')?.getAttribute('aria-disabled') === 'false'")


def test_the_stop_key_stops_at_once(page: Page) -> None:
    """The fixture's end judges the recording: at most 0.2 s from the key to the command that stays zero."""
    page.bring(damping=True)
    from selenium.webdriver.common.keys import Keys

    script = (
        "addEventListener('keydown', (event) => { window.pressedMs = event.timeStamp; }, {capture: true});"
    )
    page.browser.execute_script(script)
    with struck_again_and_again(page.configuration):
        page.await_command()
        page.browser.switch_to.active_element.send_keys(Keys.ESCAPE)
        page.until("document.getElementById('state').dataset.state === 'fault'", 5.0)
    page.stop_asked_s.append(page.monotonic_s("window.pressedMs"))
    assert "emergency stop" in page.text("state")


@pytest.mark.parametrize("key", [False, True], ids=["mouse", "key"])
@pytest.mark.parametrize(("action", "dialog"), [("strike", "ask"), ("adjust", "adjust")])
def test_a_question_leaves_the_stop_within_reach(page: Page, action: str, dialog: str, key: bool) -> None:
    """An open dialog puts the page behind it out of reach, with the stop button in its head: it has its own."""
    from selenium.webdriver.common.keys import Keys

    page.bring(damping=False)
    page.click(f"[data-action={action}]")
    page.until(f"document.getElementById('{dialog}').open")
    if key:
        reached = f"document.activeElement.matches('#{dialog} .stop')"
        for _ in range(8):  # round the dialog by Tab
            if page.browser.execute_script(f"return {reached}"):
                break
            page.browser.switch_to.active_element.send_keys(Keys.TAB)
        page.until(reached, 1.0)
        page.browser.switch_to.active_element.send_keys(Keys.ENTER)
    else:
        page.click(f"#{dialog} .stop")
    page.until("document.getElementById('state').dataset.state === 'fault'", 5.0)
    assert "emergency stop" in page.text("state")
    assert not page.browser.execute_script(f"return document.getElementById('{dialog}').open")


def test_after_a_stop_clear_and_arm_are_asked_for(page: Page) -> None:
    if page.state() != "fault":
        page.click("#stop")
        page.until("document.getElementById('state').dataset.state === 'fault'")
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
    stop_process(page.panel, 5.0)
    page.until("document.getElementById('state-word').textContent === 'No connection'", 3.0)
    page.restart_panel()
    page.until(HEARD, 5.0)
    assert page.state() in {"armed", "damping", "degraded"}  # the last where the supervisor was killed before
