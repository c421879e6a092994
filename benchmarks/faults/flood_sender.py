"""Sends given datagrams repeatedly at a given rate, from a separate process on another processor than the loop's."""

import json
import random
import socket
import subprocess
import sys
import time

import msgspec

from stillarm.benchmarks.faults.faulty_link import forged
from stillarm.common.process.child_process import start_module
from stillarm.common.process.loop_processor import leave_it_to_the_loop
from stillarm.common.user_error import UserError

RATE_HZ = 20_000
_FORGERIES = 2000
_PAUSE_S = 0.0005
_ENDS_WITHIN_S = 30.0


def start_flood(
    true: list[bytes], port: int, rate_hz: float, duration_s: float, seed: int
) -> "subprocess.Popen[bytes]":
    """Flood a port of this computer with forgeries of the `true` datagrams.

    Forgeries: noise, other keys, valid beginnings with false tags, changed bytes.
    """
    rng = random.Random(seed)
    datagrams = [forged(rng.choice(true), rng) for _ in range(_FORGERIES)]
    words = ("127.0.0.1", str(port), str(rate_hz), str(duration_s))
    process = start_module(
        "stillarm.benchmarks.faults.flood_sender", *words, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert process.stdin is not None
    with process.stdin as stdin:
        stdin.write(msgspec.msgpack.encode(datagrams))
    process.stdin = None
    return process


def sent_by(process: "subprocess.Popen[bytes]") -> int:
    """Wait until the flood has ended. Returns the number of datagrams. Raises UserError if its process failed."""
    told = process.communicate(timeout=_ENDS_WITHIN_S)[0]
    if process.returncode != 0:
        raise UserError("the flood's sender failed; see its standard error")
    return int(json.loads(told)["sent"])


def send(address: tuple[str, int], datagrams: list[bytes], rate_hz: float, duration_s: float) -> int:
    """Send for a duration. Returns the number of datagrams. Catches up when it is behind the rate."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sent, began = 0, time.monotonic()
        while (passed := time.monotonic() - began) < duration_s:
            while sent < passed * rate_hz:
                sender.sendto(datagrams[sent % len(datagrams)], address)
                sent += 1
            time.sleep(_PAUSE_S)
    return sent


def main(host: str, port: int, rate_hz: float, duration_s: float) -> int:
    """Read datagrams from standard input as a msgpack array; print the number of datagrams sent."""
    leave_it_to_the_loop()  # a real attacker would be another computer
    datagrams = msgspec.msgpack.decode(sys.stdin.buffer.read(), type=list[bytes])
    print(json.dumps({"sent": send((host, port), datagrams, rate_hz, duration_s)}), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4])))
