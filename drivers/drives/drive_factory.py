"""Opens, or asks, the drive that the configuration names. Only the named driver is imported."""

from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.files.configuration import DriveDevice
from stillarm.common.files.model import Model
from stillarm.common.link.link_key import is_loopback
from stillarm.common.user_error import UserError
from stillarm.drivers.drives.drive import Drive, DriveProbe
from stillarm.drivers.drives.udp_gateway_drive import UdpGatewayDrive, greet_gateway
from stillarm.drivers.drives.velocity_loop import VelocityLoop


def open_drive(
    config: DriveDevice, key: bytes, model: Model | None = None, name: str = "model"
) -> Drive | None:
    """The configured drive, not yet started; None for "none". model: says what the drive obeys; None: velocities.
    `name` stands for its file in messages.

    Raises UserError for a gateway on another computer with the demo key, which is public, and for a joint that obeys a
    torque, a current or a voltage behind a driver of velocities.
    """
    if config.driver == "none":
        return None
    loop = None
    if model is not None and takes_inputs(config, model.drive.kind):
        loop = VelocityLoop(model, name)
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
    return UdpGatewayDrive(config, key, loop=loop)


def takes_inputs(config: DriveDevice, kind: str) -> bool:
    """Whether the drive obeys inputs and no velocities. kind: the model's drive.kind.

    Raises UserError for a driver that commands velocities where the joint obeys a torque, a current or a voltage.
    """
    if kind != "velocity" and config.driver != "udp_gateway":
        raise UserError(
            f'drive.driver = "{config.driver}": commands velocities, but drive.kind = "{kind}" in the model; use '
            '"udp_gateway" (docs/gateway.md), or let the drive close its own velocity loop and set drive.kind = '
            '"velocity"'
        )
    return kind != "velocity"


def probe_drive(config: DriveDevice, key: bytes, span_s: float, kind: str = "velocity") -> DriveProbe:
    """Ask the configured drive without arming it. kind: the model's drive.kind. Raises UserError if it does not answer,
    or does not take what the model says that it obeys."""
    inputs = takes_inputs(config, kind)
    if config.driver == "odrive":
        from stillarm.drivers.drives.odrive_drive import OdriveDrive

        return OdriveDrive(config).probe(span_s)
    if config.driver == "cia402":
        from stillarm.drivers.drives.cia402_drive import Cia402Drive

        return Cia402Drive(config).probe(span_s)
    if config.driver == "mcp4725":
        from stillarm.drivers.drives.mcp4725_drive import Mcp4725Drive

        return Mcp4725Drive(config, wait_s=0.0).probe(span_s)
    return greet_gateway(config, key, span_s, takes_inputs=inputs)
