"""From files to files: models, configuration and scenario in, a recording and its truth out."""

from collections.abc import Callable
from pathlib import Path

import msgspec
import tomli_w

from stillarm.common.files.configuration import Configuration, default_configuration_path, load_configuration
from stillarm.common.files.model import load_model
from stillarm.common.files.output_folder import make_folder
from stillarm.common.files.scenario import load_scenario
from stillarm.common.recording.header import RecordingHeader, program_version
from stillarm.common.user_error import UserError
from stillarm.simulation.recording.recording_process import RecordingProcess
from stillarm.simulation.virtual_time.virtual_time import PartCosts, VirtualRun, simulate


def default_simulation_configuration() -> Path:
    """configs/simulated_rig.toml as it came with the program."""
    return default_configuration_path().with_name("simulated_rig.toml")


def write_simulated_recording(
    *,
    true_model_path: Path,
    assumed_model_path: Path,
    scenario_name: str,
    seed: int,
    recording_path: Path,
    truth_path: Path,
    configuration_path: Path | None = None,
    method: str | None = None,
    images: bool = False,
    progress: Callable[[float], None] = lambda done: None,
) -> tuple[PartCosts, float]:
    """Simulate a scenario and write recording and truth; returns the cost of each part and the simulated time, s.

    The same arguments give the same bytes: the files do not depend on clock, machine or paths.
    """
    if recording_path.resolve() == truth_path.resolve():
        raise UserError(
            f"{recording_path}: the recording and its truth need two files; name another with --truth"
        )
    path = configuration_path or default_simulation_configuration()
    configuration = load_configuration(path)
    if method is not None:
        settings = msgspec.structs.replace(configuration.controller, method=method)
        configuration = msgspec.structs.replace(configuration, controller=settings)
    run = VirtualRun(
        configuration,
        load_model(true_model_path),
        load_model(assumed_model_path),
        load_scenario(scenario_name),
        seed,
        images,
        str(true_model_path),
    )
    notes = {"scenario": tomli_w.dumps(msgspec.to_builtins(run.scenario))}
    header = _header(configuration, path, assumed_model_path.read_text(), seed, notes)
    true_header = _header(configuration, path, true_model_path.read_text(), seed, notes)
    make_folder(recording_path.parent)
    files = RecordingProcess([(recording_path, header), (truth_path, true_header)])
    try:
        recording, truth = files.sinks
        costs = simulate(run, recording, truth, progress)
    finally:
        files.close()
    return costs, run.scenario.duration_s


def _header(
    configuration: Configuration, path: Path, model: str, seed: int, notes: dict[str, str]
) -> RecordingHeader:
    return RecordingHeader(
        program_version=program_version(),
        configuration=tomli_w.dumps(msgspec.to_builtins(configuration)),
        configuration_name=path.name,
        model=model,
        method=configuration.controller.method,
        kind="simulated",
        seed=seed,
        notes=notes,
    )
