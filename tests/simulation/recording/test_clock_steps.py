"""Clock steps show in the rows and nowhere else."""

import msgspec
import pytest

from stillarm.common.files.configuration import Configuration
from stillarm.common.user_error import UserError
from tests.fixtures.virtual_rows import CONFIGURATION, plain_rows, run, said

pytestmark = pytest.mark.slow


def stamped() -> Configuration:
    rig = CONFIGURATION.rig
    scene = msgspec.structs.replace(rig.scene, stamped=True)
    return msgspec.structs.replace(CONFIGURATION, rig=msgspec.structs.replace(rig, scene=scene))


@pytest.mark.parametrize(("clock", "rows"), [("frames", False), ("all", True)])
def test_the_controllers_clock_steps_in_the_rows_and_nowhere_else(clock: str, rows: bool) -> None:
    step = {"cause": "clock_step", "onset_s": 1.0, "step_s": -0.25, "clock": clock}
    found = run(step)

    def stepped(time_s: float) -> float:
        return time_s - 0.25 if time_s >= 1.0 else time_s

    for was, now in zip(plain_rows()["/frames"], found["/frames"], strict=True):
        times = {"received_s": stepped(was.received_s), "started_s": stepped(was.started_s)}
        wanted = msgspec.structs.replace(was, time_s=stepped(was.time_s) if rows else was.time_s, **times)
        assert msgspec.json.encode(now) == msgspec.json.encode(wanted)
    for topic in ("/fast", "/estimate"):
        for was, now in zip(plain_rows()[topic], found[topic], strict=True):
            assert now.time_s == (stepped(was.time_s) if rows else was.time_s)
            assert now.cycle == was.cycle
    assert said(found, "/truth/state") == said(plain_rows(), "/truth/state")
    straddling = [f for f in plain_rows()["/frames"] if f.started_s < 1.0 <= f.received_s]
    assert straddling


def test_the_cameras_clock_steps_in_its_stamps_and_asks_for_stamps() -> None:
    step = {"cause": "clock_step", "onset_s": 1.0, "step_s": 0.1, "clock": "camera"}
    was, now = run(configuration=stamped()), run(step, configuration=stamped())
    jumps = [b.captured_s - a.captured_s for a, b in zip(was["/frames"], now["/frames"], strict=True)]
    mids = {frame.frame: frame.mid_exposure_s for frame in was["/truth/frames"]}
    after = [mids[frame.frame] >= 1.0 for frame in was["/frames"]]
    assert jumps == pytest.approx([0.1 if late else 0.0 for late in after], abs=1e-9)
    assert any(after) and not all(after)
    with pytest.raises(
        UserError, match=r"^rig\.toml: effects: clock_step: clock = \"camera\": [^\n]*stamped = true"
    ):
        run(step)
