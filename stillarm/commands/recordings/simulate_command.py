"""`stillarm simulate`: rig, supervisor and controller in virtual time."""

import argparse
import sys
import time
from pathlib import Path

from stillarm.arguments import seed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--model", type=Path, required=True, metavar="FILE", help="model file: the rig's true parameters"
    )
    parser.add_argument(
        "--assumed-model",
        type=Path,
        metavar="FILE",
        help="the controller's model (default: the true model)",
    )
    parser.add_argument("--scenario", default="demo", metavar="NAME", help="scenario by name or file (demo)")
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of everything random (0)")
    parser.add_argument(
        "-o", "--out", type=Path, required=True, metavar="REC", help="recording to write (MCAP)"
    )
    parser.add_argument(
        "--truth", type=Path, metavar="REC", help="truth file (default: truth.mcap beside REC)"
    )
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="configuration (default: the program's simulated_rig.toml)",
    )
    parser.add_argument(
        "--method", metavar="NAME", help="method of the controller (default: the configuration's)"
    )
    parser.add_argument(
        "--images",
        action="store_true",
        help="render and track images (default: the tracker's error model)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Simulate, and report the computing time of each part."""
    from stillarm.common.files.effects import declared, not_used_by_controller
    from stillarm.common.files.model import load_model
    from stillarm.progress import progress_bar

    assumed_path = arguments.assumed_model or arguments.model
    if unused := not_used_by_controller(load_model(assumed_path)):
        print(unused)
    with progress_bar("simulate") as progress:
        # these imports take a second: the bar comes first
        from stillarm.simulation.arm.ahead import ready_plant
        from stillarm.simulation.virtual_time.simulated_recording import write_simulated_recording

        if sys.stderr.isatty():  # compiles once after an installation, and says so
            ready_plant(declared(load_model(arguments.model)), str(arguments.model))
        started = time.perf_counter()
        costs, duration_s = write_simulated_recording(
            true_model_path=arguments.model,
            assumed_model_path=assumed_path,
            scenario_name=arguments.scenario,
            seed=arguments.seed,
            recording_path=arguments.out,
            truth_path=arguments.truth or arguments.out.with_name("truth.mcap"),
            configuration_path=arguments.config,
            method=arguments.method,
            images=arguments.images,
            progress=progress,
        )
    took = time.perf_counter() - started
    for part, seconds in sorted(costs.seconds.items(), key=lambda item: -item[1]):
        print(f"  {part:<24}{seconds:7.2f} s  {1e6 * seconds / duration_s / 1000.0:6.1f} us a millisecond")
    print(
        f"{arguments.out}: {duration_s:g} s simulated in {took:.2f} s, "
        f"{duration_s / took:.1f} times faster than real time (seed {arguments.seed})"
    )
    return 0
