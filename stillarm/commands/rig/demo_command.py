"""`stillarm demo`: rig, supervisor and controller in real time, then replay and figures."""

import argparse
import time
from pathlib import Path
from typing import Any

from stillarm.arguments import seed
from stillarm.common.user_error import UserError

_DURATION_S, _HIDDEN_DURATION_S = 30.0, 60.0
_OURS = "fused"
_LOOK_S, _PANEL_ENDS_WITHIN_S = 0.2, 5.0
_LOST_SHARE = 0.1  # of the frames; with more losses, the run shows the computer's load rather than the method
# of the cycles: 1.5 % missed left the error at 0.8 %, 36 % made it 6.3 % (load 4 on two cores)
_MISSED_SHARE = 0.1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--duration-s", type=float, metavar="S", help="length of the run (30; with --hide 60)"
    )
    parser.add_argument("--out", type=Path, default=Path("demo"), metavar="DIR", help="output folder (demo)")
    parser.add_argument(
        "--accelerometer",
        metavar="NAME",
        help="accelerometer that the rig emulates, by its registers or frames: lis3lv02dq, lis3dh, "
        "adxl345, adxl355, mpu6050, icm20948, witmotion, xsens, vectornav, microcontroller (the configuration's)",
    )
    parser.add_argument(
        "--drive",
        metavar="NAME",
        help="drive that the rig emulates: udp_gateway, odrive, cia402, mcp4725 (the configuration's)",
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of everything random (0)")
    parser.add_argument(
        "--hide",
        type=seed,
        metavar="SEED",
        help="draw an effect from SEED and hide it in the rig, for `stillarm diagnose` to find",
    )
    parser.add_argument(
        "--panel",
        action="store_true",
        help="run until Ctrl-C, with a page in the browser that shows the arm, strikes it and allows the damping",
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the demo and print its table."""
    if arguments.panel:
        return _with_panel(arguments)
    from stillarm.progress import progress_bar

    hide = arguments.hide
    duration_s = arguments.duration_s
    if duration_s is None:
        duration_s = _DURATION_S if hide is None else _HIDDEN_DURATION_S
    print(
        f"A flexible arm is struck at 2 s and rings; it is struck again at {0.6 * duration_s:g} s and damped."
    )
    from stillarm.simulation.demo.demo import run_demo  # takes a second: the line comes first

    summary = run_demo(
        arguments.out,
        duration_s,
        arguments.seed,
        progress_bar,
        arguments.accelerometer,
        drive=arguments.drive,
        hide=hide,
    )
    if hide is not None:
        print("The rig contains a hidden effect that its model does not describe. To find it:")
        print(f"stillarm diagnose {arguments.out / 'recording.mcap'}")
        return 0
    print_table(summary)
    print(
        f"Figures, recording.mcap and summary.json are in {arguments.out}; begin with {arguments.out / 'overview.png'}"
    )
    return 0


def _with_panel(arguments: argparse.Namespace) -> int:
    """Run the demo's processes and the panel until Ctrl-C. The damping is held until the page allows it."""
    from stillarm.commands.rig.panel_command import require_panel

    if arguments.hide is not None or arguments.duration_s is not None:
        raise UserError("demo: --panel runs until Ctrl-C, without --hide and --duration-s; leave those out")
    require_panel()
    from stillarm.common.process.child_process import start_module, stop_process
    from stillarm.common.process.parent_death import ended_with_parent
    from stillarm.progress import progress_bar
    from stillarm.simulation.demo.attended import attended_demo

    with attended_demo(
        arguments.out, arguments.seed, progress_bar, arguments.accelerometer, arguments.drive
    ) as demo:
        words = ("--config", str(demo.configuration), "--recordings", str(arguments.out), "--port", "0")
        panel = start_module("stillarm", "panel", *words, "--hold-damping", preexec_fn=ended_with_parent())
        try:
            while panel.poll() is None:
                demo.check()
                time.sleep(_LOOK_S)
        finally:
            stop_process(panel, _PANEL_ENDS_WITHIN_S)
    raise UserError("demo: the panel ended; its message above tells why")


def print_table(summary: dict[str, Any]) -> None:
    """Print the demo's results as a table."""
    damping = summary["damping"]
    free = damping["settling_time_free_s"] or damping["settling_time_free_fitted_s"]
    print(f"{'':<26}{'free':>10}{'damped':>10}")
    print(
        f"{'settling time to 5 %, s':<26}{_number(free, 2):>10}{_number(damping['settling_time_damped_s'], 2):>10}"
    )
    ratios = _number(damping["damping_ratio_free"], 3), _number(damping["damping_ratio_damped"], 3)
    print(f"{'damping ratio':<26}{ratios[0]:>10}{ratios[1]:>10}")
    print(f"{'':<26}" + "".join(f"{name:>14}" for name in summary["methods"]))
    for label, key, factor, digits in (
        ("capture delay, ms", "delay_mean_s", 1e3, 1),
        ("delay error rms, ms", "delay_error_rms_s", 1e3, 1),
        ("prediction error mean, %", "prediction_error_mean", 100.0, 1),
    ):
        values = (_number(m[key], digits, factor) for m in summary["methods"].values())
        print(f"{label:<26}" + "".join(f"{value:>14}" for value in values))
    if comparison := comparison_line(summary["methods"]):
        print(comparison)
    print(
        f"{summary['cycles']} cycles, {summary['deadline_misses']} deadlines missed, "
        f"{summary['frames']} frames, {summary['frames_lost']} lost; "
        f"replay {'identical' if summary['replay_identical'] else 'DIFFERENT'}"
    )
    if too_busy_for := overload(summary):
        print(
            f"This computer was too busy for {too_busy_for}, so the figures mean little; close other programs"
        )


def overload(summary: dict[str, Any]) -> str:
    """What the computer had no time for; empty if it had."""
    short = []
    if summary["deadline_misses"] > _MISSED_SHARE * (summary["cycles"] + summary["deadline_misses"]):
        short.append("the loop's cycles")
    if summary["frames_lost"] > _LOST_SHARE * (summary["frames"] + summary["frames_lost"]):
        short.append("the camera's images")
    return " and ".join(short)


def comparison_line(methods: dict[str, dict[str, Any]]) -> str:
    """Our method compared with the others in one sentence; empty if there is nothing to compare."""
    error = {name: scores.get("prediction_error_mean") for name, scores in methods.items()}
    own = error.get(_OURS)
    others = [(name, value) for name, value in error.items() if name != _OURS and value is not None]
    if own is None or not others:
        return ""
    against = ", ".join(f"{name} {100.0 * value:.1f} %" for name, value in others)
    best_name, best = min(others, key=lambda each: each[1])
    if best < own:
        return f"{_OURS} predicts to {100.0 * own:.1f} % on average, worse than {best_name} here (against {against})"
    return f"{_OURS} predicts to {100.0 * own:.1f} % on average, against {against}"


def _number(value: float | None, digits: int, factor: float = 1.0) -> str:
    return "-" if value is None else f"{factor * value:.{digits}f}"
