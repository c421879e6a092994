"""`python docs/screenshots`: the pictures of the panel, docs/panel-*.png, from a demo in a real browser.

`python docs/screenshots FOLDER` puts them there, each in light and in dark, for somebody's eyes. Needs Debian's
chromium and chromium-driver, an idle computer and some two minutes.
"""

import base64
import sys
import tempfile
from contextlib import nullcontext
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

import msgspec  # noqa: E402
import tomli_w  # noqa: E402

import stillarm  # noqa: E402
from stillarm.common.files.scenario import Scenario, Strike  # noqa: E402
from stillarm.common.link.free_ports import free_ports  # noqa: E402
from stillarm.common.process.child_process import stop_process  # noqa: E402
from stillarm.simulation.demo.attended import attended_demo  # noqa: E402
from stillarm.simulation.demo.hidden_effect import revealing_moves  # noqa: E402
from stillarm.simulation.demo.set_up import STRUCK_M  # noqa: E402
from tests.fixtures.shown_page import ShownPage, opened_browser, start_panel  # noqa: E402

SEED = 3
SIZE = 1280, 720
HIDDEN = {"cause": "joint_friction", "velocity_loss_rad_s": 0.006}
"""What the diagnosed rig has and its model lacks."""
STRUCK_S, RINGS_S, DAMPED_S = (
    3.0,
    3.5,
    4.0,
)  # the demo's first strike; it rings, is damped, and is struck again
MOVES_S = 40.0
DIAGNOSED_WITHIN_S = 300.0


class Pictures:
    """Takes the page as it is, once or in both colour schemes."""

    def __init__(self, page: ShownPage, folder: Path | None) -> None:
        """folder: for both schemes; None: docs/, light."""
        self._page, self._folder = page, folder
        self.for_eyes = folder is not None

    def take(self, name: str) -> None:
        """NAME.png, or NAME-light.png and NAME-dark.png."""
        for scheme in ("dark", "light") if self._folder else ("light",):
            self._page.look(*SIZE, scheme)
            self._page.until("document.readyState === 'complete'")
            self._page.pause(0.6)
            png = self._page.browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})["data"]
            path = self._folder / f"{name}-{scheme}.png" if self._folder else ROOT / "docs" / f"{name}.png"
            path.write_bytes(base64.b64decode(png))
            print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB", flush=True)


def main(words: list[str]) -> int:
    """Run the demo, and take the pictures."""
    folder = Path(words[0]) if words else None
    with tempfile.TemporaryDirectory() as made:
        recordings = Path(made) / "demo"
        (port,) = free_ports(1)
        demo = attended_demo(recordings, SEED, lambda label: nullcontext(lambda done: None))
        with opened_browser(*SIZE) as browser:
            page = ShownPage(browser)
            pictures = Pictures(page, folder)
            with demo as running:
                words_of_panel = ("--recordings", str(recordings), "--port", str(port))
                panel, address = start_panel(
                    "--config", str(running.configuration), *words_of_panel, "--hold-damping"
                )
                try:
                    browser.get(address)
                    live(page, pictures)
                finally:
                    stop_process(panel, 5.0)
                configuration = running.configuration
            friction(recordings)
            panel, address = start_panel("--config", str(configuration), *words_of_panel)
            try:
                browser.get("about:blank")
                browser.get(address)
                recorded(page, pictures)
            finally:
                stop_process(panel, 5.0)
    return 0


def live(page: ShownPage, pictures: Pictures) -> None:
    """The arm is struck, by the demo itself, rings, is damped, and is struck again."""
    page.until("document.getElementById('state').dataset.state === 'armed'", 60.0)
    page.await_time(STRUCK_S + RINGS_S)
    page.operate("allow_damping", confirm=True)
    page.await_time(STRUCK_S + RINGS_S + DAMPED_S)
    page.operate("strike", confirm=True)
    page.pause(1.5)
    pictures.take("panel-live")
    if not pictures.for_eyes:
        return
    page.click("[data-action=adjust]")
    page.until("document.getElementById('adjust').open")
    pictures.take("panel-adjust")
    page.click("#adjust-cancel")
    page.click("#tab-commission")
    pictures.take("panel-commission")


def friction(recordings: Path) -> None:
    """A recording of a rig with friction that its model does not have, as slow_moves.mcap."""
    known = stillarm.Model.read(ROOT / "configs" / "model.toml")
    true = msgspec.structs.replace(known, effects=[HIDDEN])
    scenario = Scenario(
        duration_s=MOVES_S, moves=revealing_moves(3.0, MOVES_S), strikes=[Strike(1.0, STRUCK_M)]
    )
    path = recordings / "slow_moves.toml"
    path.write_text(tomli_w.dumps(msgspec.to_builtins(scenario)))
    run = stillarm.simulate(true, path, SEED, assumed=known)
    Path(run.recording.path).rename(recordings / "slow_moves.mcap")


def recorded(page: ShownPage, pictures: Pictures) -> None:
    """A moment of the demo; the diagnosis of the rig with friction."""
    page.open_recording("recording.mcap")
    page.until("!document.getElementById('rec-play').disabled", 60.0)
    end_s = float(page.browser.execute_script("return Number(document.getElementById('rec-time').max)"))
    page.seek(max(0.0, end_s - 12.0))
    page.pause(1.0)
    pictures.take("panel-recording")
    page.open_recording("slow_moves.mcap")
    page.until("!document.getElementById('rec-play').disabled")
    page.click("#rec-diagnose")
    page.until("document.getElementById('report-dialog').open", DIAGNOSED_WITHIN_S)
    page.pause(2.0)
    pictures.take("panel-diagnosis")


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
