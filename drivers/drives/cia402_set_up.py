"""Sets up a CiA 402 drive by SDO: identity, mode, dead-man timer, PDO mapping. Before the loop, since SDOs take time.

The mapping: RPDO1 = 6040 control word, 60FF target velocity; TPDO1 = 6041 status word, 6064 position; TPDO2 = 606C
velocity; the TPDOs answer every SYNC. Each drive uses the dead-man timers that it supports: it monitors this
program's heartbeat (1016), and RPDO1 (event timer, 1400:05). The reaction is a quick stop (6007 = 3).
"""

import contextlib
import logging
from collections.abc import Iterator
from typing import Any

from stillarm.common.files.configuration import Cia402Device
from stillarm.common.user_error import UserError

MASTER = 127  # this program's node number, whose heartbeat the drive monitors
DEAD_MAN_MS = 100
_ON_SYNC = 1
_OFF = 0x8000_0000
_QUICK_STOP_ON_LOSS = 3
_REMEDY = "pip install 'stillarm[can]'"


def can_package() -> Any:
    """The package python-can. Raises UserError with the remedy if it is absent."""
    try:
        import can
    except ImportError:
        raise UserError(
            f"drive.driver = 'cia402': the package python-can is not installed; {_REMEDY}"
        ) from None
    return can


def open_can(config: Cia402Device) -> Any:
    """The bus that the configuration names. Raises UserError with a remedy."""
    can = can_package()
    place = f"drive.cia402.interface = {config.interface!r}, drive.cia402.channel = {config.channel!r}"
    try:
        return can.Bus(
            interface=config.interface,
            channel=config.channel,
            bitrate=config.bitrate,
            # For other interfaces python-can filters by itself; recv(0) then returns None for each filtered message.
            can_filters=_filters(config.node) if config.interface == "socketcan" else None,
        )
    except (can.CanError, OSError, ValueError, NotImplementedError) as error:
        raise UserError(
            f"{place}: cannot be opened ({' '.join(str(error).lower().split())}); bring the interface up "
            f"(`ip link set {config.channel} up type can bitrate {config.bitrate}`), or correct the names"
        ) from None


def _filters(node: int) -> list[dict[str, int | bool]]:
    return [
        {"can_id": kind + node, "can_mask": 0x7FF, "extended": False} for kind in (0x180, 0x280, 0x580, 0x700)
    ]


@contextlib.contextmanager
def remote_node(config: Cia402Device) -> Iterator[Any]:
    """The drive as a canopen node for SDOs, on a separate bus object. Raises UserError if canopen is absent."""
    try:
        import canopen
    except ImportError:
        raise UserError(f"drive.driver = 'cia402': the package canopen is not installed; {_REMEDY}") from None
    logging.getLogger("canopen").setLevel(logging.CRITICAL)  # the driver reports its errors in one line
    network = canopen.Network(open_can(config))
    network.NOTIFIER_CYCLE = 0.02  # time that a disconnect waits for its thread, s
    try:
        network.connect()
        node = network.add_node(config.node, canopen.ObjectDictionary())  # type: ignore[no-untyped-call]
        node.sdo.RESPONSE_TIMEOUT = 0.3
        yield node
    except canopen.SdoCommunicationError:
        raise UserError(
            f"drive.cia402.node = {config.node}: no drive answers on {config.channel!r}; check its power, the wiring "
            "and the two terminating resistors, its bit rate, and its node number"
        ) from None
    except canopen.SdoAbortedError as error:
        raise UserError(
            f"drive.cia402.node = {config.node}: the drive refuses a setting ({' '.join(str(error).lower().split())}); "
            "see its object dictionary, or choose another drive.cia402.mode"
        ) from None
    finally:
        network.disconnect()


def identity(node: Any) -> str:
    """Device type, vendor and product of the drive. Raises canopen's errors."""
    device_type = _read(node, 0x1000, 0)
    return (
        f"CiA {device_type & 0xFFFF}, vendor {_read(node, 0x1018, 1):#x}, product {_read(node, 0x1018, 2):#x}"
    )


def set_up(config: Cia402Device) -> str:
    """Check that the node is a CiA 402 drive and set it up: operational, not enabled. Returns its identity.

    Raises UserError with a remedy: no answer, another device, a refused setting, no dead-man timer.
    """
    with remote_node(config) as node:
        device_type = _read(node, 0x1000, 0) & 0xFFFF
        if device_type != 402:
            raise UserError(
                f"drive.cia402.node = {config.node}: a device of profile {device_type} answers, not a CiA 402 "
                "drive; correct drive.cia402.node"
            )
        name = identity(node)
        node.nmt.state = "PRE-OPERATIONAL"
        _write(node, 0x6060, 0, config.mode, 1)
        _map(node, 0x1400, 0x1600, 0x200 + config.node, 255, (0x60400010, 0x60FF0020))
        _map(node, 0x1800, 0x1A00, 0x180 + config.node, _ON_SYNC, (0x60410010, 0x60640020))
        _map(node, 0x1801, 0x1A01, 0x280 + config.node, _ON_SYNC, (0x606C0020,))
        _dead_man(node, config)
        node.nmt.state = "OPERATIONAL"
        return name


def fault_code(config: Cia402Device) -> int:
    """Object 603F, the code of the last fault. Raises UserError."""
    with remote_node(config) as node:
        return _read(node, 0x603F, 0)


def look(config: Cia402Device) -> tuple[str, int, int]:
    """Identity, status word and position, by SDO, without changes. Raises UserError."""
    with remote_node(config) as node:
        position = int.from_bytes(node.sdo.upload(0x6064, 0), "little", signed=True)
        return identity(node), _read(node, 0x6041, 0), position


def _dead_man(node: Any, config: Cia402Device) -> None:
    """Make the drive stop when this program falls silent. Raises UserError if it supports neither timer."""
    import canopen

    kept = 0
    for index, sub, value, size in (
        (0x1016, 1, MASTER << 16 | DEAD_MAN_MS, 4),
        (0x1400, 5, DEAD_MAN_MS, 2),
    ):
        with contextlib.suppress(canopen.SdoAbortedError):
            _write(node, index, sub, value, size)
            kept += 1
    if not kept:
        raise UserError(
            f"drive.cia402.node = {config.node}: the drive monitors neither heartbeat (1016) nor RPDO1 (1400:05): it "
            "would run on when commands cease; use another drive, or a gateway with a dead-man timer in front of it"
        )
    with contextlib.suppress(canopen.SdoAbortedError):  # without it the drive keeps its default
        _write(node, 0x6007, 0, _QUICK_STOP_ON_LOSS, 2)


def _map(
    node: Any, communication: int, mapping: int, identifier: int, kind: int, objects: tuple[int, ...]
) -> None:
    """Map objects into a PDO, which is switched off in the meantime, as CiA 301 requires."""
    _write(node, communication, 1, _OFF | identifier, 4)
    _write(node, communication, 2, kind, 1)
    _write(node, mapping, 0, 0, 1)
    for place, what in enumerate(objects, 1):
        _write(node, mapping, place, what, 4)
    _write(node, mapping, 0, len(objects), 1)
    _write(node, communication, 1, identifier, 4)


def _write(node: Any, index: int, sub: int, value: int, size: int) -> None:
    node.sdo.download(index, sub, value.to_bytes(size, "little"))


def _read(node: Any, index: int, sub: int) -> int:
    return int.from_bytes(node.sdo.upload(index, sub), "little")
