"""The floor of a cycle's sections: what any loop has to call, and nothing else, at the loop's own pace.

Two datagrams sent (the timestamp and the command), one I2C transfer, one sleep. What is received, computed and recorded
has no floor: it depends on how that is done. At another pace the floor would be lower, since caches stay warm.
"""

import time

import smbus2

from stillarm.benchmarks.loop.sections import Section, late_ns
from stillarm.common.files.configuration import Configuration
from stillarm.common.link.udp import UdpSocket
from stillarm.controller.loop.schedule import CycleClock
from stillarm.drivers.accelerometers.register_tables import TABLES
from stillarm.drivers.buses.i2c import open_bus

_DATAGRAM = bytes(48)  # about as long as a timestamp or a command
_LEAD_S = 0.01
_MOST_WAITING = 16


def floor_ns(configuration: Configuration, cycles: int, cycle_s: float) -> dict[Section, list[int]]:
    """What each call took in each cycle, ns, and how late the cycle woke. The registers are provided elsewhere."""
    socket = UdpSocket(("127.0.0.1", 0), "latency")
    bus = open_bus(configuration.accelerometer.bus)
    messages, address, now = _messages(configuration), socket.address, time.perf_counter_ns
    sensed, commanded, late = [], [], []
    clock = CycleClock(cycle_s, time.monotonic() + _LEAD_S)
    try:
        cycle = clock.start()
        for _ in range(cycles):
            late.append(late_ns(clock, cycle, cycle_s))
            began = now()
            socket.send(_DATAGRAM, address)
            bus.i2c_rdwr(*messages)
            sensed_at = now()
            socket.send(_DATAGRAM, address)
            commanded.append(now() - sensed_at)
            sensed.append(sensed_at - began)
            socket.drain(_MOST_WAITING)
            cycle = clock.wait(cycle)
    finally:
        bus.close()
        socket.close()
    return {Section.SENSE: sensed, Section.COMMAND: commanded, Section.SLEEP: late}


def _messages(configuration: Configuration) -> list[smbus2.i2c_msg]:
    """A transfer of status and data, as the driver's."""
    table = TABLES[configuration.accelerometer.driver]
    address = configuration.accelerometer.address or table.addresses[0]
    length = table.data_register - table.status_register + table.data_length
    register = table.status_register | table.auto_increment
    return [smbus2.i2c_msg.write(address, [register]), smbus2.i2c_msg.read(address, length)]
