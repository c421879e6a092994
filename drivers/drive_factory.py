"""Opens the drive that the configuration names. Only the named driver is imported."""

from common.configuration import DriveDevice
from common.datagram import DEMO_KEY
from common.link_key import is_loopback
from common.user_error import UserError
from drivers.drive import Drive
from drivers.udp_gateway_drive import UdpGatewayDrive


def open_drive(config: DriveDevice, key: bytes) -> Drive | None:
    """The configured drive, not yet started; None for "none".

    Raises UserError for a gateway on another computer with the demo key, which is public.
    """
    if config.driver == "none":
        return None
    if config.driver == "odrive":
        from drivers.odrive_drive import OdriveDrive

        return OdriveDrive(config)
    if config.driver == "cia402":
        from drivers.cia402_drive import Cia402Drive

        return Cia402Drive(config)
    if config.driver == "mcp4725":
        from drivers.mcp4725_drive import Mcp4725Drive

        return Mcp4725Drive(config)
    if key == DEMO_KEY and not is_loopback(config.gateway_host):
        raise UserError(
            f"drive.gateway_host = {config.gateway_host!r} lies outside this computer, where the demo key "
            "(127.0.0.0/8 only) protects nothing; name a key file in link.key_file, with mode 600"
        )
    return UdpGatewayDrive(config, key)
