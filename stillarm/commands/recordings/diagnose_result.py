"""Results of a diagnosis: its files, its verdict in one sentence, and the worth of the extended model."""

import json
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stillarm.common.user_error import UserError

if TYPE_CHECKING:
    from stillarm.common.files.model import Model
    from stillarm.diagnosis.driven.diagnosed import DrivenResult
    from stillarm.diagnosis.report.result import Result


def write(result: "Result", folder: Path, await_use: Callable[[], None]) -> None:
    """Write diagnosis.json, extended.toml and report.html. await_use: result of `put_to_use`.

    The verdict is written first, since the drawing of the report may be interrupted.
    """
    from stillarm.diagnosis.report.extended_model import model_text
    from stillarm.diagnosis.report.page import report_page

    (folder / "extended.toml").write_text(model_text(result.extended))
    _write_table(result, folder)
    page = report_page(result, await_use)
    _write_table(result, folder)  # now including the gain by the extended model
    (folder / "report.html").write_text(page)


def write_driven(result: "DrivenResult", folder: Path) -> None:
    """The same files of a joint that a torque, a current or a voltage drives."""
    from stillarm.diagnosis.driven.page import report_page
    from stillarm.diagnosis.report.extended_model import model_text

    (folder / "extended.toml").write_text(model_text(result.extended))
    _write_table(result, folder)
    (folder / "report.html").write_text(report_page(result))


def write_view(table: dict[str, Any], extended: "Model", folder: Path) -> None:
    """diagnosis.json and extended.toml of one of a rig's recordings, which were diagnosed together."""
    from stillarm.diagnosis.report.extended_model import model_text

    (folder / "extended.toml").write_text(model_text(extended))
    _write(table, folder)


def _write_table(result: "Result | DrivenResult", folder: Path) -> None:
    _write(result.table, folder)


def _write(table: dict[str, Any], folder: Path) -> None:
    text = json.dumps(_plain(table), indent=2, allow_nan=False) + "\n"
    (folder / "diagnosis.json").write_text(text)


def put_to_use(
    result: "Result",
    path: Path,
    model: "Model | None",
    pairs: int,
    run_each: Callable[..., Iterable[Any]],
) -> Callable[[], None]:
    """Start to simulate what the controller gains by the extended model, if that differs and can be run.

    Returns a function that waits for the simulation and adds it to the result. pairs: number of pairs of runs.
    run_each: `map`, or the `map` of an executor.
    """
    from stillarm.common.files.configuration import load_configuration
    from stillarm.common.recording.reader import open_recording
    from stillarm.diagnosis.diagnose import model_of
    from stillarm.diagnosis.report.use import begin_use
    from stillarm.simulation.virtual_time.simulated_recording import default_simulation_configuration

    table = result.table
    if result.found.final.world.measured.pair or not (table["findings"] or table["baseline_changes"]):
        return lambda: None
    plain = model or model_of(open_recording(path))
    configuration = load_configuration(default_simulation_configuration())
    try:
        found = begin_use(plain, result.extended, configuration, pairs=pairs, run_each=run_each)
    except UserError as error:
        found = _not_simulated(error)

    def await_use() -> None:
        try:
            table["use"] = found()
        except UserError as error:
            table["use"] = _not_simulated(error)()

    return await_use


def _not_simulated(error: UserError) -> Callable[[], dict[str, Any]]:
    return lambda: {"before": None, "after": None, "note": f"not simulated: {error}"}


def _plain(value: Any) -> Any:
    """Numbers for JSON: null for values that are not finite."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return value
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def sentence(table: dict[str, Any]) -> str:
    """The verdict in one sentence, and what another verdict might have come from: what of the recording could not be
    read, and what there was no time for."""
    from stillarm.diagnosis.report.words import unread

    lost = unread(table)
    return _verdict(table) + (f"{lost}; the rest was diagnosed" if lost else "") + short_of_time(table)


def short_of_time(table: dict[str, Any]) -> str:
    """What the budget did not suffice for, apart from what the model is worth; empty if it did."""
    stages = [one for one in table["looked_at"]["left_out"] if one != "use"]
    return (
        f". The time did not suffice for {' and '.join(stages)}: give it more with --budget-s"
        if stages
        else ""
    )


def _verdict(table: dict[str, Any]) -> str:
    from stillarm.diagnosis.report.tables import is_sure_of

    parts = []
    for finding in table["findings"]:
        numbers = finding["parameters"].items()
        values = ", ".join(f"{name} = {one['value']:.4g} +- {one['std']:.2g}" for name, one in numbers)
        near = finding["indistinguishable_from"]
        name = " or ".join([finding["cause"], *near])
        cut = 100.0 * finding["held_out"]["reduction"]
        unsure = (
            ""
            if is_sure_of(finding, table)
            else f"hardly, with confidence {max(finding['confidence'], 0.001):.2g}: "
        )
        where = f" only in {', '.join(finding['only_in'])}" if "only_in" in finding else ""
        parts.append(f"{unsure}{name}{where} ({values}; cuts the held-out error by {cut:.0f} %)")
    impacts = f"; {len(table['events'])} impacts or pulls that no sensor measured" if table["events"] else ""
    if table["verdict"] == "none":
        return f"nothing wrong with the simulation beyond its parameters{impacts}"
    if table["verdict"] == "named":
        return f"{'; then '.join(parts)}{impacts}"
    left = table["unexplained"]
    low, high = left["band_hz"]
    rest = (
        f"{left['channel']} holds structure at {low:.3g} to {high:.3g} Hz that no known cause explains "
        f"(depends on: {left['dependence']})"
    )
    surely = bool(parts) and is_sure_of(table["findings"][0], table)
    return "; ".join([*parts, rest] if surely else [rest, *parts]) + impacts
