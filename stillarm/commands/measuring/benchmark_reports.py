"""`stillarm benchmark NAME`: runs one benchmark, prints its tables, and returns what --json writes."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from stillarm.common.user_error import UserError
from stillarm.printed_rows import brief_estimator_row, print_rows
from stillarm.progress import progress_bar

DEFAULT_DURATION_S = {"loop": 60.0, "flood": 10.0, "soak": 1800.0, "live": 30.0, "panel": 120.0}


def _vision(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.vision import run as run_vision

    with progress_bar("benchmark vision"):
        result = run_vision(trials, arguments.seed)
    print_rows(result["rows"])
    return result


def _hardware(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.hardware import run as run_hardware
    from stillarm.benchmarks.hardware_drives import camera_rows, drive_rows

    with progress_bar("benchmark hardware"):
        result = run_hardware(trials, arguments.seed)
        result |= {"drives": drive_rows(trials), "cameras": camera_rows()}
    for table in ("rows", "drives", "cameras"):
        print_rows(result[table])
        print()
    return result


def _estimators(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.estimators.run import Part, campaign, draw
    from stillarm.benchmarks.estimators.run import run as run_estimators

    names = {
        option: _listed(getattr(arguments, option)) for option in ("methods", "regimes", "tables", "rows")
    }
    part = Part(noises=_noises(arguments.noises), **names)
    what = campaign(trials, arguments.seed, part, arguments.quick)
    with progress_bar("benchmark estimators") as progress:
        result = run_estimators(what, progress)
    for table in ("rows", "damping", "conditions", "doubts"):
        if result[table]:
            print_rows([brief_estimator_row(row) for row in result[table]])
            print()
    worse = [row for row in result["comparisons"] if row["worse"]]
    if worse:
        print("cells in which fused is worse than another method by more than two paired standard errors:")
        print_rows(worse)
        print()
    empty = result["empty_cycle_us"]
    print(
        f"a cycle that only exchanges the datagrams: mean {empty['mean']:.1f} us, median {empty['median']:.1f} us"
    )
    if arguments.out is not None:
        for path in draw(result, what, arguments.out):
            print(path)
    return result


def _listed(text: str | None) -> list[str] | None:
    return text.split(",") if text else None


def _numbers(option: str, text: str | None) -> list[float] | None:
    try:
        return [float(one) for one in text.split(",")] if text else None
    except ValueError:
        raise UserError(
            f"--{option} {text}: numbers separated by commas are needed, such as 0.1,0.3"
        ) from None


def _noises(text: str | None) -> list[float] | None:
    numbers = _numbers("noises", text)
    if numbers and not all(0.0 < one <= 100.0 for one in numbers):
        raise UserError(
            f"--noises {text}: each must be above 0 and at most 100 (of the amplitude's acceleration)"
        )
    return numbers


def _diagnosis(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.diagnosis.campaign import run as run_campaign
    from stillarm.benchmarks.diagnosis.tables import lines

    with progress_bar("benchmark diagnosis") as progress:
        result = run_campaign(trials, arguments.seed, arguments.resume, progress)
    for line in lines(result):
        print(line)
    if arguments.resume is not None:
        print(arguments.resume / "confusion.png")
    return result


def _identification(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.identification import run_all

    with progress_bar("benchmark identification") as progress:
        result = run_all(arguments.data, progress)
    if result["rows"]:
        print_rows(result["rows"])
    speed = result["simulation"]
    print(
        f"simulation of {speed['simulated_s']:.0f} s, two modes: {1e3 * speed['ours_s']:.1f} ms, "
        f"{speed['times_real_time']:.0f} times real time; scipy's solve_ivp {speed['solve_ivp_s']:.1f} s, "
        f"{speed['solve_ivp_times_real_time']:.1f} times; largest difference {speed['largest_difference']:.1e}"
    )
    if arguments.data is None:
        print(
            "--data FOLDER with the measured sets adds a comparison with a subspace fit, PySINDy and SysIdentPy"
        )
    return result


def _commission(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.commissioning import run as run_commissioning
    from stillarm.benchmarks.commissioning import shown

    with progress_bar("benchmark commission") as progress:
        result = run_commissioning(trials, arguments.seed, progress)
    for table in (shown(result["rows"]), result["parameters"]):
        if table:
            print_rows(table)
            print()
    for one in result["refused"]:
        print(f"rig {one['seed']}: {one['error']}")
    print(
        f"within 3 stated deviations {result['within_3_std']:.1%} of {trials} rigs' parameters; within the allowed "
        f"errors {result['within_need']:.0%} of rigs, signs right {result['signs_right']:.0%}, damped at once "
        f"{result['damps_at_once']:.0%}"
    )
    return result


def _faults(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.faults.run import run as run_faults

    with progress_bar("benchmark faults") as progress:
        result = run_faults(trials, arguments.seed, progress)
    print_rows(result["rows"])
    for text in result["violation_texts"]:
        print(text)
    print(
        f"{result['injections']} injections of {result['kinds']} kinds, {result['live_injections']} of them into the "
        f"real processes: {result['violations']} violations"
    )
    return result


def _flood(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.faults.flood import run as run_flood

    with progress_bar("benchmark flood") as progress:
        result = run_flood(_duration_s(arguments), arguments.seed, progress)
    print_rows(result["rows"])
    print()
    print_rows(result["asked"])
    refused = ", ".join(f"{name} {count}" for name, count in result["refused"].items())
    print(f"{result['sent']} forged datagrams, {result['rate_hz']:.0f} a second; refused: {refused}")
    return result


def _duration_s(arguments: argparse.Namespace) -> float:
    return float(arguments.duration_s or DEFAULT_DURATION_S[arguments.name])


def _soak(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.soak import run as run_soak

    with progress_bar("benchmark soak") as progress:
        result = run_soak(_duration_s(arguments), arguments.seed, progress)
    print_rows([{"process": name, **values} for name, values in result["processes"].items()])
    print(
        f"soak, {result['duration_s']:g} s: {'; '.join(result['problems']) or 'nothing grows, nothing drifts'}"
    )
    return result


def _panel(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.commands.rig.panel_command import require_panel

    require_panel()
    from stillarm.benchmarks.panel_pages import run as run_panel

    with progress_bar("benchmark panel") as progress:
        result = run_panel(_duration_s(arguments), arguments.seed, progress)
    print_rows(result["rows"])
    return result


def _loop(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.loop.run import run as run_loop
    from stillarm.benchmarks.loop.run import verdict
    from stillarm.commands.measuring.latency_command import print_latency

    with progress_bar("benchmark loop") as progress:
        duration_s = _duration_s(arguments) if arguments.trials is None else float(trials)
        result = run_loop(duration_s, arguments.seed, progress)
    print_latency(result)
    print()
    print_rows(verdict(result))
    return result


def _live(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    if arguments.kill_supervisor is not None:
        return _kills(arguments, trials)
    from stillarm.benchmarks.live.picture import draw
    from stillarm.benchmarks.live.run import run as run_live
    from stillarm.benchmarks.live.tables import by_method, by_run, verdict

    methods = arguments.methods.split(",") if arguments.methods else None
    result = run_live(
        trials,
        arguments.load or 0,
        arguments.seed,
        _duration_s(arguments),
        methods,
        arguments.keep,
        progress_bar,
        lambda line: print(line, flush=True),
    )
    print()
    for table in (by_method(result["rows"]), by_run(result["rows"]), verdict(result["rows"], result["load"])):
        print_rows(table)
        print()
    print(draw(result, arguments.out or Path("live")))
    return result


def _kills(arguments: argparse.Namespace, trials: int) -> dict[str, Any]:
    from stillarm.benchmarks.live.kills.kill_run import run_all_kills
    from stillarm.benchmarks.live.kills.kill_tables import by_gap, verdict

    for option in ("duration_s", "out"):
        if getattr(arguments, option) is not None:
            raise UserError(f"--{option.replace('_', '-')}: not with --kill-supervisor; leave it out")
    result = run_all_kills(
        trials,
        _numbers("kill-supervisor", arguments.kill_supervisor) or [],
        arguments.load or 0,
        arguments.seed,
        _listed(arguments.methods),
        arguments.keep,
        progress_bar,
        lambda line: print(line, flush=True),
    )
    print()
    for table in (by_gap(result["rows"]), verdict(result["rows"])):
        print_rows(table)
        print()
    return result


REPORTS: dict[str, Callable[[argparse.Namespace, int], dict[str, Any]]] = {
    "estimators": _estimators,
    "vision": _vision,
    "loop": _loop,
    "live": _live,
    "faults": _faults,
    "flood": _flood,
    "soak": _soak,
    "panel": _panel,
    "diagnosis": _diagnosis,
    "commission": _commission,
    "identification": _identification,
    "hardware": _hardware,
}
