"""The demo's own configuration: free ports, names of its own, its scenario; written to the output folder."""

import secrets
import tomllib
from pathlib import Path

import msgspec
import tomli_w

from stillarm.common.files.configuration import (
    AccelerometerDevice,
    Configuration,
    DriveDevice,
    load_configuration,
    model_path,
)
from stillarm.common.files.model import load_model
from stillarm.common.files.scenario import Scenario, Strike, Window
from stillarm.common.files.typed_toml import convert_tree
from stillarm.common.link.free_ports import free_ports
from stillarm.common.user_error import UserError
from stillarm.drivers.emulation.emulated_accelerometer import emulated_driver
from stillarm.simulation.demo.hidden_effect import draw_effect, revealing_moves
from stillarm.simulation.sensors.accelerometer_model import as_read, with_device
from stillarm.simulation.virtual_time.simulated_recording import default_simulation_configuration

RIG_MODEL_NAME = "rig_model.toml"
EMULATED_DRIVES = ("udp_gateway", "odrive", "cia402", "mcp4725")
_MOTOR_TURNS = {"odrive": -25.0, "cia402": 25.0, "mcp4725": 1.0}  # gears as a rig has them, either sense
STRUCK_M = 0.00625  # the accelerometer's noise of 0.5 m/s^2 is 0.3 of this vibration's acceleration
SHORTEST_S = 12.0
LONGEST_S = 600.0
DAMPING_BEFORE_STRIKE_S = 0.25  # so that it has faded in at the impact


def demo_scenario(duration_s: float, *, moves: bool = False) -> Scenario:
    """Struck at 2 s, rings freely until 60 % of the time; struck again with damping just on, until the end.

    moves: whether the joint also moves, from 42 % of the time on, when the free vibration has been scored.
    """
    second = round(0.6 * duration_s, 3)
    return Scenario(
        duration_s=duration_s,
        strikes=[Strike(2.0, STRUCK_M), Strike(second, STRUCK_M)],
        moves=revealing_moves(0.42 * duration_s, second - DAMPING_BEFORE_STRIKE_S) if moves else [],
        damping=[Window(second - DAMPING_BEFORE_STRIKE_S, duration_s + 60.0)],
    )


def write_demo_configuration(
    directory: Path,
    duration_s: float,
    seed: int,
    accelerometer: str | None = None,
    *,
    drive: str | None = None,
    hide: int | None = None,
) -> tuple[Path, Configuration, Scenario]:
    """Write config.toml, model.toml and scenario.toml into `directory`; returns the configuration and where it lies.

    accelerometer: a driver's name, through whose emulated registers or frames the rig presents itself; its delay, range
    and noise then go into the models, what the rig truly has into rig_model.toml. Raises UserError for a name that is
    none. drive: likewise. hide: seed of an effect that goes into rig_model.toml alone; whatever the effect, what the
    others see of it is that file's name, a camera that stamps, and moves of the joint.
    """
    source = default_simulation_configuration()
    configuration = load_configuration(source)
    scenario = demo_scenario(duration_s, moves=hide is not None)
    scenario_path = (directory / "scenario.toml").resolve()
    model_text = model_path(configuration, source).read_text()
    name = secrets.token_hex(4)
    ports = free_ports(5)
    replace = msgspec.structs.replace
    configuration = replace(
        configuration,
        model="model.toml",
        link=replace(
            configuration.link, controller_port=ports[0], supervisor_port=ports[1], reference_port=ports[2]
        ),
        drive=_emulated_drive(configuration.drive, drive, name, ports[3], ports[4]),
        accelerometer=replace(
            configuration.accelerometer,
            driver=emulated_driver(accelerometer or configuration.accelerometer.driver),
            bus=f"memory:demo-{name}-i2c",
            port=f"pty:demo-{name}-accelerometer",
        ),
        camera=replace(configuration.camera, device=f"demo-{name}-camera"),
        controller=replace(configuration.controller, schedule=str(scenario_path)),
        rig=replace(configuration.rig, scenario=str(scenario_path), seed=seed),
    )
    if accelerometer is not None:
        configuration = replace(configuration, rig=replace(configuration.rig, model=RIG_MODEL_NAME))
    if hide is not None:
        scene = replace(configuration.rig.scene, stamped=True)
        configuration = replace(
            configuration, rig=replace(configuration.rig, model=RIG_MODEL_NAME, scene=scene)
        )
    path = directory / "config.toml"
    path.write_text(
        tomli_w.dumps(msgspec.to_builtins(configuration))
    )  # first: it marks the folder as a demo's
    scenario_path.write_text(tomli_w.dumps(msgspec.to_builtins(scenario)))
    (directory / "model.toml").write_text(model_text)
    if accelerometer is not None:
        _write_models_of(configuration.accelerometer, directory)
    if hide is not None:
        true = tomllib.loads(
            model_text if accelerometer is None else (directory / RIG_MODEL_NAME).read_text()
        )
        true["effects"] = [draw_effect(hide, duration_s)]
        (directory / RIG_MODEL_NAME).write_text(tomli_w.dumps(true))
    return path, configuration, scenario


def _write_models_of(device: AccelerometerDevice, directory: Path) -> None:
    """Put the device into model.toml, as the loop sees it, and into rig_model.toml, as it truly is."""
    model = load_model(directory / "model.toml")
    true = with_device(model.accelerometer, device)
    assumed = as_read(true, device, model.timing.cycle_s)
    for name, accelerometer in ((RIG_MODEL_NAME, true), ("model.toml", assumed)):
        tree = msgspec.to_builtins(msgspec.structs.replace(model, accelerometer=accelerometer))
        (directory / name).write_text(tomli_w.dumps(tree))


def _emulated_drive(
    device: DriveDevice, driver: str | None, name: str, gateway_port: int, local_port: int
) -> DriveDevice:
    """The drive through whose emulator the rig presents itself, on ports and buses of this demo's own.

    Raises UserError for a name that is none.
    """
    replace = msgspec.structs.replace
    driver = device.driver if driver is None else driver
    if driver not in EMULATED_DRIVES:
        raise UserError(f"--drive {driver}: no such drive; use {', '.join(EMULATED_DRIVES)}")
    return convert_tree(
        msgspec.to_builtins(
            replace(
                device,
                gateway_port=gateway_port,
                local_port=local_port,
                odrive=replace(device.odrive, port=f"pty:demo-{name}-drive"),
                cia402=replace(
                    device.cia402,
                    interface="udp_multicast",
                    channel="239.74.163.2",
                    node=1 + secrets.randbelow(120),  # other demos may be on this bus
                    velocity_units_s_per_turn=65536.0,
                    position_units_per_turn=65536.0,
                ),
                mcp4725=replace(device.mcp4725, bus=f"memory:demo-{name}-dac"),
            )
        )
        | {"driver": driver, "gear_ratio": 1.0 if driver == "udp_gateway" else _MOTOR_TURNS[driver]},
        DriveDevice,
        "--drive",
    )
