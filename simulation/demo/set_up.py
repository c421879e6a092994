"""The demo's own configuration: free ports, names of its own, its scenario; written to the output folder."""

import secrets
import socket
from pathlib import Path

import msgspec
import tomli_w

from common.configuration import Configuration, load_configuration, model_path
from common.scenario import Scenario, Strike, Window
from simulation.simulated_recording import default_simulation_configuration

STRUCK_M = 0.00625  # the accelerometer's noise of 0.5 m/s^2 is 0.3 of this vibration's acceleration
SHORTEST_S = 12.0
LONGEST_S = 600.0
DAMPING_BEFORE_STRIKE_S = 0.25  # so that it has faded in when the blow falls


def demo_scenario(duration_s: float) -> Scenario:
    """Struck at 2 s, rings freely until 60 % of the time; struck again with damping just on, until the end."""
    second = round(0.6 * duration_s, 3)
    return Scenario(
        duration_s=duration_s,
        strikes=[Strike(2.0, STRUCK_M), Strike(second, STRUCK_M)],
        damping=[Window(second - DAMPING_BEFORE_STRIKE_S, duration_s + 60.0)],
    )


def write_demo_configuration(
    directory: Path, duration_s: float, seed: int
) -> tuple[Path, Configuration, Scenario]:
    """Write config.toml, model.toml and scenario.toml into `directory`; returns the configuration and where it lies."""
    source = default_simulation_configuration()
    configuration = load_configuration(source)
    scenario = demo_scenario(duration_s)
    scenario_path = (directory / "scenario.toml").resolve()
    model_text = model_path(configuration, source).read_text()
    name = secrets.token_hex(4)
    ports = _free_ports(5)
    replace = msgspec.structs.replace
    configuration = replace(
        configuration,
        model="model.toml",
        link=replace(
            configuration.link, controller_port=ports[0], supervisor_port=ports[1], reference_port=ports[2]
        ),
        drive=replace(configuration.drive, gateway_port=ports[3], local_port=ports[4]),
        accelerometer=replace(configuration.accelerometer, bus=f"memory:demo-{name}-i2c"),
        camera=replace(configuration.camera, device=f"demo-{name}-camera"),
        controller=replace(configuration.controller, schedule=str(scenario_path)),
        rig=replace(configuration.rig, scenario=str(scenario_path), seed=seed),
    )
    path = directory / "config.toml"
    path.write_text(
        tomli_w.dumps(msgspec.to_builtins(configuration))
    )  # first: it marks the folder as a demo's
    scenario_path.write_text(tomli_w.dumps(msgspec.to_builtins(scenario)))
    (directory / "model.toml").write_text(model_text)
    return path, configuration, scenario


def _free_ports(count: int) -> list[int]:
    """Ports that nobody listens on now; all are held until all are known, so that they differ."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    try:
        for held in sockets:
            held.bind(("127.0.0.1", 0))
        return [int(held.getsockname()[1]) for held in sockets]
    finally:
        for held in sockets:
            held.close()
