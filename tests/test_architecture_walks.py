"""docs/architecture.md walks an image, a cycle and a recording through the code: the stations are there, and few."""

import ast
import re
import secrets
import sys
import time
from functools import cache
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any, cast

import pytest

from stillarm.benchmarks.loop.loopback_rig import LoopbackRig, loopback_configuration
from stillarm.common.memory.shared_memory import SharedRing
from stillarm.common.recorder.recorder_client import RecorderClient
from stillarm.controller.loop.live_devices import LiveDevices
from stillarm.controller.loop.loop import Loop
from stillarm.controller.loop.schedule import CycleClock
from stillarm.controller.loop.step import Controller
from stillarm.controller.statistics.loop_block import LoopBlock
from tests.fixtures.imports import ROOT

PAGE = ROOT / "docs" / "architecture.md"
WALKS = (
    "One image, from its datagram to the command",
    "One cycle of the loop",
    "One recording, to its verdict",
)
MOST_STATIONS = 12
MOST_FILES = 18  # of ours, that an image passes
CYCLES = 300  # of a run that sees some twenty images


def stations(walk: str) -> list[str]:
    """The rows of a walk's table."""
    section = PAGE.read_text(encoding="utf-8").split(f"## {walk}\n", 1)[1].split("\n## ", 1)[0]
    return re.findall(r"^\| \d+ \|.*\|$", section, re.M)


@cache
def defined(path: Path) -> frozenset[str]:
    """Functions and classes of a module, and methods as Class.method."""
    names = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {f"{node.name}.{one.name}" for one in node.body if isinstance(one, ast.FunctionDef)}
    return frozenset(names)


def places(row: str) -> list[tuple[str, str]]:
    """File and function of each place in a station."""
    found = re.findall(r"\[([\w.]+)\]\(\.\./([\w/.]+)\) `([\w.]+)`", row)
    assert found and all(Path(file).name == name for name, file, _ in found), row
    return [(file, function) for _, file, function in found]


@pytest.mark.parametrize("walk", WALKS)
def test_each_station_is_a_function_that_is_there(walk: str) -> None:
    rows = stations(walk)
    assert rows
    for row in rows:
        for file, function in places(row):
            assert function in defined(ROOT / file), f"{file} has no {function}"


@pytest.mark.parametrize("walk", WALKS)
def test_a_walk_has_at_most_twelve_stations_in_order(walk: str) -> None:
    numbers = [int(row.split("|")[1]) for row in stations(walk)]
    assert numbers == list(range(1, len(numbers) + 1))
    assert len(numbers) <= MOST_STATIONS


def test_an_image_passes_few_files() -> None:
    assert len({file for row in stations(WALKS[0]) for file, _ in places(row)}) <= MOST_FILES


class Paced(CycleClock):
    """Before each cycle the rig does its part. A cycle takes four times as long: the counting of calls costs."""

    def __init__(self, rig: LoopbackRig, cycle_s: float) -> None:
        super().__init__(4.0 * cycle_s, time.monotonic())
        self._rig = rig

    def wait(self, last: int) -> int:
        self._rig.advance(last + 1)
        return super().wait(last)


@pytest.fixture(scope="module")
def callers() -> dict[tuple[str, str], set[str]]:
    """Which files call each function of ours, by file and name, while a loop on real sockets sees images."""
    callers: dict[tuple[str, str], set[str]] = {}

    def file_of(frame: FrameType | None) -> str:
        path = Path(frame.f_code.co_filename).resolve() if frame is not None else ROOT
        return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else ""

    def see(frame: FrameType, event: str, argument: object) -> None:
        if event == "call":
            called = file_of(frame), frame.f_code.co_qualname
            callers.setdefault(called, set()).add(file_of(frame.f_back))

    configuration, model = loopback_configuration()
    rig, devices = LoopbackRig(configuration, model), LiveDevices(configuration, model)
    name = f"test-walks-{secrets.token_hex(4)}"
    ring, block = SharedRing(f"{name}-ring", 1 << 22, create=True), LoopBlock(name, create=True)
    recorder = RecorderClient(cast(Any, SimpleNamespace(poll=lambda: None)), ring)
    cycle_s = model.timing.cycle_s
    try:
        rig.start(devices)
        sys.setprofile(see)
        controller = Controller(model, configuration.controller)
        Loop(controller, devices, recorder, block, Paced(rig, cycle_s), cycle_s).run(lambda n: n >= CYCLES)
    finally:
        sys.setprofile(None)
        devices.close()
        rig.close()
        block.close()
        ring.close()
    return callers


@pytest.mark.slow
@pytest.mark.parametrize("walk", WALKS[:2])
def test_a_walk_leaves_out_no_file_between_its_stations(
    walk: str, callers: dict[tuple[str, str], set[str]]
) -> None:
    """Each station is called in a run of the loop: by the loop, its step, a file of the walk, or where this module
    stands in for the daemon."""
    walked = [place for row in stations(walk) for place in places(row)]
    files = {file for file, _ in walked} | {"controller/loop/loop.py", "controller/loop/step.py"}
    files.add(str(Path(__file__).relative_to(ROOT)))
    for place in walked:
        by = callers.get(place, set())
        assert by & files, f"{place}: called from {by}"


@pytest.mark.parametrize("page", [PAGE, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8"))
    for link in links:
        assert "://" in link or (page.parent / link).exists(), link
