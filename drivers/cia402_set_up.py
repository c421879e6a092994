"""Setting a CiA 402 drive up by SDO: identity, mode, dead man, PDO mapping. Before the loop only: SDOs take time.

The mapping: RPDO1 = 6040 control word, 60FF target velocity; TPDO1 = 6041 status word, 6064 position; TPDO2 = 606C
velocity; the TPDOs answer every SYNC. The dead man is what the drive offers of two: it listens for this program's
heartbeat (1016), and it watches RPDO1 (its event timer, 1400:05); what it does then is a quick stop (6007 = 3).
"""

import contextlib
import logging
from collections.abc import Iterator
from typing import Any

from common.configuration import Cia402Device
from common.user_error import UserError

MASTER = 127  # this program's node number, whose heartbeat the drive listens for
DEAD_MAN_MS = 100
_ON_SYNC = 1
_OFF = 0x8000_0000
_QUICK_STOP_ON_LOSS = 3
_REMEDY = "pip install 'stillarm[can]'"


def can_package() -> Any:
    """The package python-can. Raises UserError with the remedy where it is absent."""
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
            # Elsewhere python-can filters by itself, and then recv(0) gives None for every message that it turns away.
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
    """The drive as a canopen node, for SDOs, on a bus of its own. Raises UserError where canopen is absent."""
    try:
        import canopen
    except ImportError:
        raise UserError(f"drive.driver = 'cia402': the package canopen is not installed; {_REMEDY}") from None
    logging.getLogger("canopen").setLevel(logging.CRITICAL)  # what it has to say, the driver says in one line
    network = canopen.Network(open_can(config))
    network.NOTIFIER_CYCLE = 0.02  # how long a disconnect waits for its thread, s
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
            "see its object dictionary, or take another drive.cia402.mode"
        ) from None
    finally:
        network.disconnect()


def identity(node: Any) -> str:
    """Device type, vendor and product as the drive tells them. Raises canopen's errors."""
    device_type = _read(node, 0x1000, 0)
    return (
        f"CiA {device_type & 0xFFFF}, vendor {_read(node, 0x1018, 1):#x}, product {_read(node, 0x1018, 2):#x}"
    )


def set_up(config: Cia402Device) -> str:
    """Check that the node is a CiA 402 drive and set it up, operational, not enabled; returns its identity.

    Raises UserError with a remedy: nobody answers, another device, a setting refused, no dead man.
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
    """Identity, status word and position, by SDO, changing nothing. Raises UserError."""
    with remote_node(config) as node:
        position = int.from_bytes(node.sdo.upload(0x6064, 0), "little", signed=True)
        return identity(node), _read(node, 0x6041, 0), position


def _dead_man(node: Any, config: Cia402Device) -> None:
    """Have the drive stop when this program falls silent. Raises UserError for one that does neither."""
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
            f"drive.cia402.node = {config.node}: the drive watches neither heartbeat (1016) nor RPDO1 (1400:05): it "
            "would run on when commands cease; take another drive, or put a gateway with a dead-man timer before it"
        )
    with contextlib.suppress(canopen.SdoAbortedError):  # without it the drive does what it does by itself
        _write(node, 0x6007, 0, _QUICK_STOP_ON_LOSS, 2)


def _map(
    node: Any, communication: int, mapping: int, identifier: int, kind: int, objects: tuple[int, ...]
) -> None:
    """Map objects into a PDO: switched off meanwhile, as CiA 301 wants it."""
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
