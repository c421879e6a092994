"""`stillarm operate`: arm, disarm, clear a fault or stop a running controller, by signed datagram."""

import argparse
import time
from pathlib import Path

from stillarm.common.files.configuration import Configuration, load_configuration
from stillarm.common.link.link_key import load_key
from stillarm.common.link.operator_sender import OperatorSender
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.user_error import UserError

_WORDS = {
    "arm": "the joint may move",
    "disarm": "the command fades to zero",
    "clear": "a fault is acknowledged; `arm` is needed next",
    "stop": "emergency stop: the command is zero at once, until `clear` and `arm`",
}
_ANSWER_WITHIN_S = 1.0
_REPEATS, _PAUSE_S = 3, 0.01


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    words = "; ".join(f"{word}: {meaning}" for word, meaning in _WORDS.items())
    parser.add_argument("word", choices=tuple(_WORDS), metavar="WORD", help=words)
    parser.add_argument(
        "--config", type=Path, required=True, metavar="FILE", help="the controller's configuration file"
    )


def run(arguments: argparse.Namespace) -> int:
    """Send the command, and report it."""
    configuration = load_configuration(arguments.config)
    where = operate(configuration, arguments.word)
    print(f"{arguments.word}: sent to the controller at {where}: {_WORDS[arguments.word]}")
    return 0


def operate(configuration: Configuration, word: str) -> str:
    """Send a command to the running controller; returns its address. Raises UserError when none answers."""
    from stillarm.controller.safety.table import Operator

    bits = Operator.EMERGENCY_STOP if word == "stop" else Operator[word.upper()]
    link = configuration.link
    controller = (link.controller_host, link.reference_port)
    sender = OperatorSender(load_key(link), new_session())
    socket = UdpSocket(
        (link.controller_host if controller[0].startswith("127.") else "0.0.0.0", 0), "operate"
    )
    try:
        deadline = time.monotonic() + _ANSWER_WITHIN_S
        while not sender.known:
            if time.monotonic() > deadline:
                raise UserError(
                    f"operate: no controller answers at {controller[0]}:{controller[1]}; start it, or name the "
                    "configuration that it uses (link.reference_port, link.key_file)"
                )
            socket.send(sender.command(bits), controller)
            time.sleep(_PAUSE_S)
            sender.take(socket.drain(16))
        for _ in range(_REPEATS):
            socket.send(sender.command(bits), controller)
            time.sleep(_PAUSE_S)
    finally:
        socket.close()
    return f"{controller[0]}:{controller[1]}"
