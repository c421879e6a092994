"""Emergency switch, signal and datagrams of the operator."""

import os
import signal
from pathlib import Path

import pytest

from stillarm.common.datagrams.datagram import DEMO_KEY, encode
from stillarm.common.datagrams.messages import OperatorCommand, Reference
from stillarm.common.files.configuration import Safety
from stillarm.common.link.operator_sender import OperatorSender
from stillarm.common.process.stop_signal import SignalFlag
from stillarm.common.user_error import UserError
from stillarm.controller.input.exchange import ReferenceExchange
from stillarm.controller.input.operator_input import OperatorInput
from stillarm.controller.safety.table import Operator
from tests.fixtures.link_ends import SENDER, SESSION
from tests.reference.plain_datagram import OPERATOR_COMMAND, plain_datagram


def test_the_switch_is_read_in_every_cycle_and_anything_unreadable_stops(tmp_path: Path) -> None:
    """Its value stops, another does not; an emptied file and a closed one do."""
    switch = tmp_path / "value"
    switch.write_text("0\n")
    operator = OperatorInput(Safety(emergency_stop_input=str(switch)), None)
    operator.start()
    for text, wanted in (
        ("0\n", 0),
        ("1\n", Operator.EMERGENCY_STOP),
        ("0\n", 0),
        ("", Operator.EMERGENCY_STOP),
    ):
        switch.write_text(text)
        assert operator.asked() == wanted
    operator.close()
    assert operator.asked() == Operator.EMERGENCY_STOP
    operator.close()


def test_a_switch_that_is_not_there_refuses_the_start(tmp_path: Path) -> None:
    """In one line, with key and value."""
    operator = OperatorInput(Safety(emergency_stop_input=str(tmp_path / "none")), None)
    with pytest.raises(UserError, match=r"controller\.safety\.emergency_stop_input = .*none.*no such file"):
        operator.start()


def test_the_signal_stops_once_each_time_it_comes() -> None:
    """SIGUSR1."""
    before = signal.getsignal(signal.SIGUSR1)
    try:
        operator = OperatorInput(Safety(), SignalFlag(signal.SIGUSR1))
        assert operator.asked() == 0
        os.kill(os.getpid(), signal.SIGUSR1)
        assert operator.asked() == Operator.EMERGENCY_STOP
        assert operator.asked() == 0
    finally:
        signal.signal(signal.SIGUSR1, before)


@pytest.mark.parametrize("value", [0, 16, -1, True, 1.0, "arm", None])
def test_a_datagram_that_is_no_command_is_ignored(value: object) -> None:
    """Well signed and in order all the same."""
    exchange, sender = ReferenceExchange(DEMO_KEY, SESSION), OperatorSender(DEMO_KEY, SENDER)
    exchange.take([plain_datagram(DEMO_KEY, OPERATOR_COMMAND, SENDER, 1, (value,), echo=SESSION)], 0.0)
    assert exchange.asked() == 0
    assert exchange.hello() is None
    exchange.take([sender.command(1)], 0.0)


def test_an_operator_does_not_end_a_reference() -> None:
    """Both come to one socket, each with a session of its own."""
    exchange = ReferenceExchange(DEMO_KEY, SESSION)
    reference = encode(DEMO_KEY, SENDER + 2, 1, Reference(0.1, True), echo=SESSION)
    later = encode(DEMO_KEY, SENDER + 2, 2, Reference(0.2, True), echo=SESSION)
    command = encode(DEMO_KEY, SENDER, 1, OperatorCommand(2), echo=SESSION)
    exchange.take([reference, command, later], 0.0)
    assert exchange.reference(0.0) == (0.2, True)
    assert exchange.asked() == Operator.DISARM
