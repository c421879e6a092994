"""Opens, or asks, the drive that the configuration names. Only the named driver is imported."""

from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.files.configuration import DriveDevice
from stillarm.common.link.link_key import is_loopback
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive import Drive, DriveProbe
from stillarm.drivers.drives.udp_gateway_drive import UdpGatewayDrive, greet_gateway


def open_drive(config: DriveDevice, key: bytes) -> Drive | None:
    """The configured drive, not yet started; None for "none".

    Raises UserError for a gateway on another computer with the demo key, which is public.
    """
    if config.driver == "none":
        return None
    if config.driver == "odrive":
        from stillarm.drivers.drives.odrive_drive import OdriveDrive

        return OdriveDrive(config)
    if config.driver == "cia402":
        from stillarm.drivers.drives.cia402_drive import Cia402Drive

        return Cia402Drive(config)
    if config.driver == "mcp4725":
        from stillarm.drivers.drives.mcp4725_drive import Mcp4725Drive

        return Mcp4725Drive(config)
    if key == DEMO_KEY and not is_loopback(config.gateway_host):
        raise UserError(
            f"drive.gateway_host = {config.gateway_host!r} lies outside this computer, where the demo key "
            "(127.0.0.0/8 only) protects nothing; name a key file in link.key_file, with mode 600"
        )
    return UdpGatewayDrive(config, key)


def probe_drive(config: DriveDevice, key: bytes, span_s: float) -> DriveProbe:
    """Ask the configured drive without arming it. Raises UserError if it does not answer."""
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
