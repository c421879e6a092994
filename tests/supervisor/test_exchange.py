"""The supervisor's end: cycles in flight come back in order."""

from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.controller.input.exchange import ControllerExchange
from stillarm.supervisor.exchange import SupervisorExchange
from tests.fixtures.link_ends import sample


def test_cycles_in_flight_come_back_in_order() -> None:
    """Four images asked for ahead: each comes with the timestamp of its own request."""
    controller, supervisor = ControllerExchange(DEMO_KEY, 11), SupervisorExchange(DEMO_KEY, 22, 4)
    controller.expect(22)
    started = []
    for cycle in range(0, 150, 15):
        supervisor.take([controller.timestamp(cycle)])
        supervisor.begin_cycles()
        started.append(supervisor.oldest().cycle)
        supervisor.end_cycle(sample(supervisor.oldest().cycle))
    assert started == [0, 0, 0, 0, 15, 30, 45, 60, 75, 90]
