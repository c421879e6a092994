"""`stillarm operate`: arm, disarm, clear a fault, stop, or adjust a running controller, by signed datagram."""

import argparse
import time
from collections.abc import Callable
from math import isfinite, nan
from pathlib import Path

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.files.configuration import Configuration, load_configuration
from stillarm.common.link.link_key import load_key
from stillarm.common.link.operator_sender import OperatorSender
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.user_error import UserError
from stillarm.progress import tell_terminal

_WORDS = {
    "arm": "the joint may move",
    "disarm": "the command fades to zero",
    "clear": "a fault is acknowledged; `arm` is needed next",
    "stop": "emergency stop: the command is zero at once, until `clear` and `arm`",
}
_VALUE_WORDS = {
    "gain": "added damping ratio VALUE, at once where nothing is damped, else faded out and in",
    "method": "method VALUE; refused while damping",
}
_ANSWER_WITHIN_S = 1.0
_STOPPED_WITHIN_S = 5.0  # a controller that starts meanwhile is stopped, too
_REPEATS, _PAUSE_S = 3, 0.01
_MOST_DATAGRAMS = 256  # at each look; the telemetry sends fewer in that time


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    words = "; ".join(f"{word}: {meaning}" for word, meaning in (_WORDS | _VALUE_WORDS).items())
    parser.add_argument("word", choices=(*_WORDS, *_VALUE_WORDS), metavar="WORD", help=words)
    parser.add_argument(
        "value", nargs="?", metavar="VALUE", help="of gain and method; controller.adjustable bounds it"
    )
    parser.add_argument(
        "--config", type=Path, required=True, metavar="FILE", help="the controller's configuration file"
    )


def run(arguments: argparse.Namespace) -> int:
    """Send the command, and report it."""
    word, value = arguments.word, arguments.value
    configuration = load_configuration(arguments.config)
    if word in _VALUE_WORDS:
        method, ratio = asked_adjustment(word, value)
        print(f"{word} {value}: {adjust(configuration, method, ratio)}")
        return 0
    if value is not None:
        raise UserError(f"operate {word}: takes no value; leave out {value!r}")
    where = operate(configuration, word)
    print(f"{word}: sent to the controller at {where}: {_WORDS[word]}")
    return 0


def asked_adjustment(word: str, value: str | None) -> tuple[str, float]:
    """Method (empty: as it is) and added damping ratio (NaN: as it is). Raises UserError."""
    if word == "method":
        if not value:
            raise UserError("operate method: name one, as in `stillarm operate method fused`")
        return value, nan
    try:
        ratio = float(value or "")
    except ValueError:
        ratio = nan
    if not isfinite(ratio):
        given = "" if value is None else f" {value!r}"
        raise UserError(
            f"operate gain{given}: give an added damping ratio, as in `stillarm operate gain 0.1`"
        )
    return "", ratio


def operate(configuration: Configuration, word: str) -> str:
    """Send a command to the running controller; returns its address. Raises UserError when none answers."""
    from stillarm.controller.safety.table import Operator

    bits = Operator.EMERGENCY_STOP if word == "stop" else Operator[word.upper()]
    within_s = _STOPPED_WITHIN_S if word == "stop" else _ANSWER_WITHIN_S
    return _sent(configuration, lambda sender: sender.command(bits), within_s)


def adjust(configuration: Configuration, method: str, added_damping_ratio: float) -> str:
    """Ask the running controller for another method or gain; returns what became of it, in words.

    Raises UserError where the configuration does not allow it, no controller answers, or the controller refuses or
    does not tell in time. The state is for the controller to judge.
    """
    from stillarm.controller.safety.adjusting import adjustment_refusal
    from stillarm.panel.answer import awaited_answer

    asked = Adjustment(method, added_damping_ratio)
    if why := adjustment_refusal(asked, configuration.controller, None):
        raise UserError(f"operate: {why}")
    telemetry = configuration.telemetry
    try:
        listener = UdpSocket((telemetry.host, telemetry.panel_port), "telemetry.panel_port")
    except UserError:  # a panel has this port, or the telemetry goes to another computer
        where = _sent(configuration, lambda sender: sender.adjustment(method, added_damping_ratio))
        return (
            f"sent to the controller at {where}; what became of it is told where its telemetry goes "
            f"({telemetry.host}:{telemetry.panel_port}: the panel), and in its log"
        )
    try:
        where = _sent(configuration, lambda sender: sender.adjustment(method, added_damping_ratio))
        try:
            return awaited_answer(asked, lambda: listener.drain(_MOST_DATAGRAMS))
        except UserError as error:
            raise UserError(f"operate: the controller at {where} {error}") from None
    finally:
        listener.close()


def _sent(
    configuration: Configuration,
    packed: Callable[[OperatorSender], bytes],
    within_s: float = _ANSWER_WITHIN_S,
) -> str:
    """Meet the controller, and send what `packed` makes; returns the address."""
    link = configuration.link
    controller = (link.controller_host, link.reference_port)
    sender = OperatorSender(load_key(link), new_session())
    socket = UdpSocket(
        (link.controller_host if controller[0].startswith("127.") else "0.0.0.0", 0), "operate"
    )
    tell_terminal(
        f"operate: sends to the controller at {controller[0]}:{controller[1]}, and waits for its answer"
    )
    try:
        deadline = time.monotonic() + within_s
        while not sender.known:
            if time.monotonic() > deadline:
                raise UserError(
                    f"operate: no controller answers at {controller[0]}:{controller[1]}; start it, or name the "
                    "configuration that it uses (link.reference_port, link.key_file)"
                )
            socket.send(packed(sender), controller)
            time.sleep(_PAUSE_S)
            sender.take(socket.drain(16))
        for _ in range(_REPEATS):
            socket.send(packed(sender), controller)
            time.sleep(_PAUSE_S)
    finally:
        socket.close()
    return f"{controller[0]}:{controller[1]}"
