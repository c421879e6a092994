"""The real processes under fault injection: rig, supervisor and controller, with a proxy on every link."""

import contextlib
import os
import signal
import subprocess
import time
from pathlib import Path

import msgspec
import tomli_w

from stillarm.benchmarks.faults.judge import Trace
from stillarm.benchmarks.faults.udp_proxy import UdpProxy
from stillarm.common.files.model import load_model
from stillarm.common.memory.shared_memory import SharedBlock, block_path
from stillarm.common.process.child_process import start_module
from stillarm.common.process.parent_death import ended_with_parent
from stillarm.common.process.priority import run_fifo
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive_gateway import DEAD_MAN_S
from stillarm.drivers.emulated_chips.shared_registers import _FAILURE_AT, Failure
from stillarm.simulation.demo.set_up import write_demo_configuration

_STRIKE_EVERY_S = 0.4
_LONGEST_S = 3600.0
_READY_WITHIN_S = 40.0
_STOP_WITHIN_S = 20.0
_PROXY_PRIORITY = 20  # SCHED_FIFO, far below the controller's


class LiveRig:
    """The three processes of a demo. Each start of the controller records into a new file."""

    def __init__(self, folder: Path, seed: int) -> None:
        """Start the processes, and wait until the joint is commanded. Raises UserError if that does not happen."""
        self.folder = folder
        _, configuration, _ = write_demo_configuration(folder, 600.0, seed)
        self.model = load_model(folder / "model.toml")
        link, drive = configuration.link, configuration.drive
        self.bus_name = configuration.accelerometer.bus.removeprefix("memory:")
        self._camera = configuration.camera.device
        self.controller_port = link.controller_port
        self.proxy = UdpProxy(
            controller_port=link.controller_port,
            supervisor_port=link.supervisor_port,
            gateway_port=drive.gateway_port,
            drive_port=drive.local_port,
            seed=seed,
        )
        replace, proxy = msgspec.structs.replace, self.proxy
        for name, changed in {
            "controller": replace(
                configuration,
                link=replace(link, supervisor_port=proxy.supervisor_port),
                drive=replace(drive, gateway_port=proxy.gateway_port),
            ),
            "supervisor": replace(configuration, link=replace(link, controller_port=proxy.controller_port)),
            "rig": configuration,
        }.items():
            (folder / f"{name}.toml").write_text(tomli_w.dumps(msgspec.to_builtins(changed)))
        count = int(_LONGEST_S / _STRIKE_EVERY_S)
        strikes = ", ".join(
            f"{{time_s = {0.5 + _STRIKE_EVERY_S * k:.1f}, deflection_m = {0.004 * (-1) ** (k * k // 3):.3f}}}"
            for k in range(count)
        )
        (folder / "scenario.toml").write_text(
            f"duration_s = {_LONGEST_S}\nstrikes = [{strikes}]\ndamping = [{{on_s = 0.0, off_s = {2 * _LONGEST_S}}}]\n"
        )
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        # The proxy must not delay datagrams; the processes that it starts have ordinary priority.
        run_fifo(_PROXY_PRIORITY)
        self.recordings = 0
        self.flood: subprocess.Popen[bytes] | None = None
        try:
            self._start_all()
        except BaseException:
            self.close()
            raise

    def _start_all(self) -> None:
        self.start("rig")
        deadline = time.monotonic() + _READY_WITHIN_S
        while not block_path(self._camera).exists():
            if time.monotonic() > deadline or self._processes["rig"].poll() is not None:
                raise UserError(f"benchmark faults: the rig did not start: {self.last_words('rig')}")
            time.sleep(0.05)
        self.start("supervisor")
        self.start("controller")
        self.await_command()

    @property
    def recording(self) -> Path:
        """The recording of the present or last controller."""
        return self.folder / f"recording{self.recordings}.mcap"

    def start(self, name: str) -> None:
        """Start a process as its service would."""
        words = [name, "--config", str(self.folder / f"{name}.toml")]
        if name == "controller":
            self.proxy.forget()
            self.recordings += 1
            words += ["--record", str(self.recording), "--allow-non-realtime"]
        with (self.folder / f"{name}.log").open("ab") as log:
            self._processes[name] = start_module(
                "stillarm",
                *words,
                stdout=log,
                stderr=log,
                preexec_fn=ended_with_parent(),  # safe: no thread runs, and it only calls the kernel
            )

    def await_command(self, within_s: float = _READY_WITHIN_S) -> float:
        """Pass datagrams on until the joint is commanded to move. Returns the time that took. Raises UserError."""
        began = time.monotonic()
        while time.monotonic() < began + within_s:
            before = len(self.proxy.seen)
            self.proxy.pump(0.05)
            if any(abs(command) > 1e-6 for _, command in self.proxy.seen[before:]):
                return time.monotonic() - began
            for name, process in self._processes.items():
                if process.poll() is not None:
                    raise UserError(f"benchmark faults: {name} ended: {self.last_words(name)}")
        raise UserError(
            f"benchmark faults: no damping within {within_s:g} s: {self.last_words('controller')}; "
            f"the logs are in {self.folder}"
        )

    def signal(self, name: str, number: signal.Signals) -> None:
        """Send a signal to a process, or to one of its children: "controller/recorder", "rig/camera"."""
        os.kill(self.process_id(name), number)

    def process_id(self, name: str) -> int:
        """Process id of a process or of a child."""
        parent, _, child = name.partition("/")
        process = self._processes[parent].pid
        if not child:
            return process
        mark = {"recorder": b"recorder_process", "camera": b"spawn_main"}[child]
        for task in Path(f"/proc/{process}/task").iterdir():
            for number in (task / "children").read_text().split():
                with contextlib.suppress(OSError):
                    if mark in Path(f"/proc/{number}/cmdline").read_bytes():
                        return int(number)
        raise UserError(f"benchmark faults: {name} does not run")

    def wait(self, name: str) -> int:
        """Pass datagrams on until a process has ended. Returns its exit status. Raises UserError if it does not end."""
        process = self._processes[name]
        deadline = time.monotonic() + _STOP_WITHIN_S
        while (status := process.poll()) is None:
            if time.monotonic() > deadline:
                raise UserError(f"benchmark faults: {name} did not end within {_STOP_WITHIN_S:g} s")
            self.proxy.pump(0.02)
        return status

    def stop(self, name: str) -> None:
        """Ask a process to stop, and wait for it. Raises UserError if it does not stop."""
        self.signal(name, signal.SIGTERM)
        self.wait(name)

    def fail_accelerometer(self, failure: Failure) -> None:
        """Set a failure in the rig's emulated accelerometer."""
        block = SharedBlock(self.bus_name, create=False)
        block.buffer[_FAILURE_AT] = failure
        block.close()

    def last_words(self, name: str) -> str:
        """The last line of a process's log, without the statistics of each second."""
        with contextlib.suppress(OSError):
            lines = (self.folder / f"{name}.log").read_text(errors="replace").strip().splitlines()
            told = [line for line in lines if '"event":"loop"' not in line]
            return told[-1] if told else "its log is empty"
        return "its log is empty"

    def log_size(self, name: str) -> int:
        """Size of a process's log, bytes."""
        return (self.folder / f"{name}.log").stat().st_size

    def said_since(self, name: str, size: int) -> str:
        """The part of a process's log after `size` bytes."""
        return (self.folder / f"{name}.log").read_bytes()[size:].decode(errors="replace")

    def trace(self, from_s: float, to_s: float) -> Trace:
        """The commands that the drive followed, in each millisecond of a span of monotonic time.

        The drive follows the last command for 0.1 s.
        """
        seen, times, commands = self.proxy.seen, [], []
        place = max(0, len(seen) - round(3000 * (to_s - from_s)) - 3000)
        last_s, last = float("-inf"), 0.0
        for step in range(round((to_s - from_s) * 1000.0)):
            now = from_s + step * 0.001
            while place < len(seen) and seen[place][0] <= now:
                last_s, last = seen[place]
                place += 1
            times.append(step * 0.001)
            commands.append(last if now - last_s <= DEAD_MAN_S else 0.0)
        return Trace(times, commands)

    def close(self) -> None:
        """Stop everything."""
        with contextlib.suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        for name in ("controller", "supervisor", "rig"):
            process = self._processes.get(name)
            if process is None or process.poll() is not None:
                continue
            process.send_signal(signal.SIGCONT)
            process.terminate()
            with contextlib.suppress(UserError):
                self.wait(name)
            if process.poll() is None:
                process.kill()
                process.wait()
        self.proxy.close()
        for name in (self.bus_name, self._camera, f"{self._camera}-pose"):
            block_path(name).unlink(missing_ok=True)
