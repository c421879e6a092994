"""`stillarm operate` refuses by itself what the configuration forbids, in one line; the rest is the controller's."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from math import isnan, nan
from pathlib import Path

import pytest

from stillarm.commands.rig.operate_command import adjust, asked_adjustment
from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.files.configuration import Configuration, Link, Telemetry
from stillarm.common.link.free_ports import free_ports
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.recorder.panel_stream import PanelStream
from stillarm.common.recording.topics import EstimateSample, LogLine
from stillarm.common.user_error import UserError
from stillarm.controller.input.exchange import ReferenceExchange
from stillarm.controller.loop.recorded import settings_sample
from stillarm.controller.safety.adjusting import Adjusted, Adjusting
from stillarm.controller.safety.table import State
from stillarm.main import main
from tests.fixtures.commands import one_line

ROOT = Path(__file__).parents[4]


def test_a_gain_is_a_number_and_a_method_a_name() -> None:
    method, ratio = asked_adjustment("method", "fused")
    assert method == "fused" and isnan(ratio)
    assert asked_adjustment("gain", "0.1") == ("", 0.1)


@pytest.mark.parametrize(
    ("word", "value", "told"),
    [
        ("gain", None, "operate gain: give an added damping ratio"),
        ("gain", "much", "operate gain 'much': give an added damping ratio"),
        ("gain", "inf", "operate gain 'inf': give an added damping ratio"),
        (
            "gain",
            "0.9",
            "added damping ratio 0.9: from 0 to 0.2; controller.adjustable.max_added_damping_ratio",
        ),
        ("method", None, "operate method: name one"),
        (
            "method",
            "kalman",
            "method 'kalman': one of fused, timestamps, correlation; controller.adjustable.methods",
        ),
        ("arm", "now", "operate arm: takes no value; leave out 'now'"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(
    word: str, value: str | None, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["operate", word, *([] if value is None else [value])]
    assert main([*words, "--config", str(ROOT / "configs" / "simulated_rig.toml")]) != 0
    assert told in one_line(capsys)


@pytest.mark.slow
def test_without_a_controller_nothing_is_adjusted() -> None:
    with pytest.raises(UserError, match=r"no controller answers at 127\.0\.0\.1:9"):
        adjust(Configuration(link=Link(reference_port=9)), "", 0.1)
    with pytest.raises(UserError, match="nothing was asked for"):
        adjust(Configuration(), "", nan)


@contextmanager
def a_controller(state: State | None) -> Iterator[Configuration]:
    """The controller's own exchange, judge and panel stream in a thread, in a state; None: it tells nothing."""
    port, panel_port = free_ports(2)
    configuration = Configuration(link=Link(reference_port=port), telemetry=Telemetry(panel_port=panel_port))
    exchange, ended = ReferenceExchange(DEMO_KEY, new_session()), threading.Event()
    judge, stream = Adjusting(configuration.controller, 0.001), PanelStream(0.0)
    socket = UdpSocket(("127.0.0.1", port), "test")

    def tell(adjusted: Adjusted | None, time_s: float) -> None:
        stream.take(settings_sample(round(time_s / 0.001), 0.001, judge.settings, adjusted))
        stream.take(EstimateSample(time_s, 0, nan, nan, "held", nan, nan, nan, 0.0, "off"))
        if adjusted is not None:
            stream.take(LogLine(time_s, *adjusted.told))

    def run() -> None:
        cycle = 0
        while not ended.wait(0.001):
            cycle += 1
            for data, sender in socket.drain_with_senders(32):
                exchange.take([data], time.monotonic())
                if hello := exchange.hello():
                    socket.send(hello, sender)
            if state is None:
                continue
            answer = judge.judge(asked, cycle, state) if (asked := exchange.adjustment()) else None
            if answer is not None:
                judge.settings = answer.settings
            if answer is not None or cycle == 1:
                tell(answer, cycle * 0.001)
            for datagram in stream.due(time.monotonic()):
                socket.send(datagram, ("127.0.0.1", panel_port))

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield configuration
    finally:
        ended.set()
        thread.join()
        socket.close()


def test_what_the_controller_took_is_told_as_in_force() -> None:
    with a_controller(State.DAMPING) as configuration:
        assert adjust(configuration, "", 0.05) == "in force (method fused, added damping ratio 0.05)"


def test_a_refusal_is_told_with_its_reason() -> None:
    refused = (
        r"the controller at 127\.0\.0\.1:\d+ refuses: the method does not change while the state is damping"
    )
    with a_controller(State.DAMPING) as configuration, pytest.raises(UserError, match=refused):
        adjust(configuration, "timestamps", nan)


def test_what_is_in_force_already_and_refused_is_refused() -> None:
    with a_controller(State.DEGRADED) as configuration, pytest.raises(UserError, match="state is degraded"):
        adjust(configuration, "", configuration.controller.damping.added_damping_ratio)


@pytest.mark.slow
def test_a_controller_that_tells_nothing_is_said_to_tell_nothing() -> None:
    with (
        a_controller(None) as configuration,
        pytest.raises(UserError, match=r"no telemetry of it came within"),
    ):
        adjust(configuration, "", 0.05)


def test_beside_a_panel_the_panel_tells() -> None:
    with a_controller(State.ARMED) as configuration:
        panel = UdpSocket(("127.0.0.1", configuration.telemetry.panel_port), "test")
        try:
            assert "what became of it is told where its telemetry goes" in adjust(configuration, "", 0.05)
        finally:
            panel.close()
