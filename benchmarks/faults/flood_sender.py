"""Whoever floods: sends given datagrams again and again at a rate, from another process, off the loop's processor."""

import json
import os
import socket
import sys
import time

import msgspec

_PAUSE_S = 0.0005


def send(address: tuple[str, int], datagrams: list[bytes], rate_hz: float, duration_s: float) -> int:
    """Send for so long; returns how many went out. Behind the rate, it catches up."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sent, began = 0, time.monotonic()
        while (passed := time.monotonic() - began) < duration_s:
            while sent < passed * rate_hz:
                sender.sendto(datagrams[sent % len(datagrams)], address)
                sent += 1
            time.sleep(_PAUSE_S)
    return sent


def main(host: str, port: int, rate_hz: float, duration_s: float) -> int:
    """Datagrams come on standard input, as a msgpack array; how many were sent goes to standard output."""
    processors = os.sched_getaffinity(0)
    if len(processors) > 1:  # as the sender would be another computer
        os.sched_setaffinity(0, processors - {max(processors)})
    datagrams = msgspec.msgpack.decode(sys.stdin.buffer.read(), type=list[bytes])
    print(json.dumps({"sent": send((host, port), datagrams, rate_hz, duration_s)}), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4])))
