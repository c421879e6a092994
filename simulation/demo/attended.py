"""A demo for somebody at a screen: rig, supervisor and controller run until they are told to stop.

Nothing is scheduled: the arm is struck on request (simulation/rig/strike_requests.py).
Telemetry goes to ports of this demo's own.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import msgspec
import tomli_w

from stillarm.common.files.scenario import Scenario, Strike
from stillarm.common.link.free_ports import free_ports
from stillarm.simulation.demo.demo import (
    Progress,
    compile_ahead,
    remove_shared_memory,
    start_all,
)
from stillarm.simulation.demo.own_folder import own_folder
from stillarm.simulation.demo.processes import DemoProcesses
from stillarm.simulation.demo.set_up import STRUCK_M, write_demo_configuration

_LONG_S = 24 * 3600.0  # of the scenario; what is struck after the first blow is on request
_FIRST_STRIKE_S = 3.0
_VIEWS_HZ = 4.0


class Attended(NamedTuple):
    """configuration: the demo's file. check: raises UserError if one of its processes has ended.

    process_ids: by name.
    """

    configuration: Path
    check: Callable[[], None]
    process_ids: dict[str, int]


@contextmanager
def attended_demo(
    directory: Path, seed: int, progress: Progress, accelerometer: str | None = None, drive: str | None = None
) -> Iterator[Attended]:
    """Run the processes while the context lasts; recording.mcap and truth.mcap stay in `directory`.

    Raises UserError when one of them does not start.
    """
    with own_folder(directory):
        path, configuration, _ = write_demo_configuration(directory, 12.0, seed, accelerometer, drive=drive)
        port, panel_port = free_ports(2)
        replace = msgspec.structs.replace
        configuration = replace(
            configuration,
            controller=replace(configuration.controller, schedule=""),
            telemetry=replace(
                configuration.telemetry, port=port, panel_port=panel_port, view_rate_hz=_VIEWS_HZ
            ),
        )
        path.write_text(tomli_w.dumps(msgspec.to_builtins(configuration)))
        scenario = Scenario(duration_s=_LONG_S, strikes=[Strike(_FIRST_STRIKE_S, STRUCK_M)])
        (directory / "scenario.toml").write_text(tomli_w.dumps(msgspec.to_builtins(scenario)))
        with progress("arm, compiled once"):
            compile_ahead(path, configuration)
        processes = DemoProcesses(directory)
        try:
            start_all(processes, path, configuration.camera.device)
            yield Attended(path, processes.check, processes.process_ids())
        finally:
            processes.stop_all()
            remove_shared_memory(configuration)
