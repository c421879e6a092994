"""Checks the drive: its presence, reports and identity. Nothing is armed, and only zero is commanded."""

import time
from collections.abc import Callable
from math import isnan

from stillarm.common.datagrams.messages import DriveCommand, DriveState, Hello
from stillarm.common.files.configuration import DriveDevice
from stillarm.common.files.model import Model
from stillarm.common.link.peer import Peer
from stillarm.common.link.udp import UdpSocket, new_session
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive import DriveProbe
from stillarm.preflight.verdict import Verdict, fail, ok, warn

_ASK_EVERY_S = 0.02
_FEWEST_PER_S = 20.0


def probe_drive(config: DriveDevice, key: bytes, span_s: float) -> DriveProbe:
    """Query the configured drive. Raises UserError if it does not answer."""
    if config.driver == "odrive":
        from stillarm.drivers.drives.odrive_drive import OdriveDrive

        return OdriveDrive(config).probe(span_s)
    if config.driver == "cia402":
        from stillarm.drivers.drives.cia402_drive import Cia402Drive

        return Cia402Drive(config).probe(span_s)
    if config.driver == "mcp4725":
        from stillarm.drivers.drives.mcp4725_drive import Mcp4725Drive

        return Mcp4725Drive(config, wait_s=0.0).probe(span_s)
    return greet_gateway(config, key, span_s)


def greet_gateway(
    config: DriveDevice,
    key: bytes,
    span_s: float,
    *,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> DriveProbe:
    """Ask a gateway for its identity with commands of zero that do not echo its session: it answers and obeys none.

    Raises UserError if it does not answer, or if the port is in use (a controller runs).
    """
    session = new_session()
    peer = Peer(key, (DriveState, Hello), session)
    socket = UdpSocket((config.local_host, config.local_port), "drive.local_port")
    place = f"{config.gateway_host}:{config.gateway_port}"
    greetings = 0
    try:
        until = clock() + span_s
        while clock() < until:
            socket.send(peer.encode(DriveCommand(0.0), echo=0), (config.gateway_host, config.gateway_port))
            sleep(_ASK_EVERY_S)
            for data in socket.drain(32):
                greetings += peer.receive(data) is not None
    finally:
        socket.close()
    if peer.counts.forged and not greetings:
        raise UserError(
            f"drive.gateway_host: {place} answers with another signature: the keys differ; copy one link.key_file to "
            "controller and gateway"
        )
    if not greetings:
        raise UserError(
            f"drive.gateway_port = {config.gateway_port}: no gateway answers at {place}; check its power and cable, "
            "start it (the simulated rig: `stillarm rig`), give it the same key, or correct drive.gateway_host and "
            "gateway_port"
        )
    return DriveProbe(f"gateway at {place}", greetings, span_s, float("nan"))


def judge_drive(probe: DriveProbe, config: DriveDevice, model: Model) -> list[Verdict]:
    """Judge the answers of a drive."""
    rate = probe.reports / max(probe.span_s, 1e-9)
    verdicts = [ok("drive", f"{probe.identity} answers")]
    if rate < _FEWEST_PER_S and config.driver != "cia402":
        verdicts.append(
            fail(
                "drive",
                f"{rate:.0f} answers a second: a lost drive could not be detected within 50 ms; check cable and baud",
            )
        )
    limits = model.drive
    if not isnan(probe.position_rad):
        inside = limits.min_position_rad <= probe.position_rad <= limits.max_position_rad
        text = f"joint at {probe.position_rad:+.3f} rad"
        span = f"{limits.min_position_rad:g} to {limits.max_position_rad:g} rad"
        verdicts.append(
            ok("drive", text)
            if inside
            else fail(
                "drive",
                f"{text}, outside the model's {span}: move it back by hand, home the encoder, or correct "
                "drive.gear_ratio",
            )
        )
    fatal = ("fault", "error", "EEPROM")
    for note in probe.notes:
        verdicts.append((fail if any(word in note for word in fatal) else warn)("drive", note))
    return verdicts
