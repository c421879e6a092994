"""Messages from a service to systemd: READY=1, WATCHDOG=1, STOPPING=1 to the socket in NOTIFY_SOCKET (sd_notify(3)).

Without systemd there is no such socket, and nothing happens. Five lines: no package is worth it.
"""

import contextlib
import os
import socket


def notify(state: str) -> bool:
    """Send a state such as "READY=1"; whether it could be sent. Never raises, never waits."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if not address:
        return False
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.setblocking(False)
        sender.sendto(state.encode(), "\0" + address[1:] if address.startswith("@") else address)
        return True
    return False


def watchdog_period_s() -> float | None:
    """Feeding period, half of WatchdogSec; None if systemd expects none."""
    try:
        microseconds = int(os.environ.get("WATCHDOG_USEC", ""))
    except ValueError:
        return None
    return microseconds / 2e6 if microseconds > 0 else None


class Watchdog:
    """Feeds systemd's watchdog, but only while a loop's counter moves: a process that lives and whose loop hangs is
    restarted. For a process that watches the loop, not for the loop.
    """

    def __init__(self) -> None:
        """Reads the period that systemd asks for."""
        self._period_s = watchdog_period_s()
        self._counter = -1
        self._next_s = float("-inf")

    def feed(self, counter: int, now_s: float) -> bool:
        """Tell systemd, if it is time and the counter has moved since it was told last; whether it was told."""
        if self._period_s is None or now_s < self._next_s or counter == self._counter:
            return False
        self._counter, self._next_s = counter, now_s + self._period_s
        return notify("WATCHDOG=1")
