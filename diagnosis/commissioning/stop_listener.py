"""The operator's stop while no controller runs: between two parts of a commissioning, as the arm rings down.

An operator who asks for a stop then is answered as by a controller, and the next part does not begin.
"""

import threading
import time

from stillarm.common.files.configuration import Link
from stillarm.common.link.link_key import load_key
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.controller.input.exchange import ReferenceExchange
from stillarm.controller.safety.table import Operator

_LOOK_S = 0.01
_MOST_DATAGRAMS = 32  # at each look


class StopListener:
    """Listens at `link.reference_port`, from a thread, until closed."""

    def __init__(self, link: Link) -> None:
        """Raises UserError where the port is taken: another controller runs."""
        session = new_session()
        self._exchange = ReferenceExchange(load_key(link), session)
        self._socket = UdpSocket((link.controller_host, link.reference_port), "link.reference_port")
        self._closing = threading.Event()
        self._asked = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="operator's stop", daemon=True)
        self._thread.start()

    @property
    def stopped(self) -> bool:
        """Whether a stop was asked for."""
        return self._asked.is_set()

    def rest(self, seconds: float) -> None:
        """Wait so long, or until a stop is asked for."""
        self._asked.wait(seconds)

    def close(self) -> None:
        """Leave the port to the next controller. May be called twice."""
        self._closing.set()
        self._thread.join()
        self._socket.close()

    def _listen(self) -> None:
        while True:
            last = self._closing.is_set()  # what came before is still read
            for data, sender in self._socket.drain_with_senders(_MOST_DATAGRAMS):
                self._exchange.take([data], 0.0)
                if answer := self._exchange.hello():
                    self._socket.send(answer, sender)
            if self._exchange.asked() & Operator.EMERGENCY_STOP:
                self._asked.set()
            if last:
                return
            time.sleep(_LOOK_S)
