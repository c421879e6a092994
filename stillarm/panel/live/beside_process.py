"""The process that runs methods beside the one in force: `python -m ... CONFIG`, started by beside_runner.py.

Standard input: blocks of a kind (u8), a length (u32) and content: TELEMETRY, a datagram, or WANTED, a JSON list of
methods. Standard output: blocks of a length (u32) and a message for the page. Little-endian.
"""

import struct
import sys
from typing import BinaryIO

import msgspec

from stillarm.common.files.configuration import load_assumed_model, load_configuration, model_path
from stillarm.common.process.stop_signal import StopSignal
from stillarm.common.user_error import UserError
from stillarm.controller.estimation.methods import all_methods
from stillarm.panel.live.beside import Beside

TELEMETRY, WANTED = 0, 1
HEAD, LENGTH = struct.Struct("<BI"), struct.Struct("<I")


def follow(beside: Beside, source: BinaryIO, out: BinaryIO) -> None:
    """Until the input ends."""
    while head := source.read(HEAD.size):
        kind, length = HEAD.unpack(head)
        content = source.read(length)
        if kind == WANTED:
            beside.want(msgspec.json.decode(content, type=list[str]))
            continue
        for message in beside.take(content):
            out.write(LENGTH.pack(len(message)) + message)
        out.flush()


def main(path: str) -> int:
    """Run; returns the exit status."""
    StopSignal()
    try:
        configuration = load_configuration(path)
        model, name = load_assumed_model(configuration, path), str(model_path(configuration, path))
        follow(
            Beside(model, configuration.controller, name, all_methods()), sys.stdin.buffer, sys.stdout.buffer
        )
    except UserError as error:
        print(f"stillarm: methods beside: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
