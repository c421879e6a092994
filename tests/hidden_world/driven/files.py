"""The files of a case: the table as a stranger saves it, its import description, the stated rig, the truth."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.io import savemat

from tests.hidden_world.driven.case import Case
from tests.hidden_world.driven.effects import CAUSES, told
from tests.hidden_world.driven.rig import Rig, luck
from tests.hidden_world.driven.written import Column, columns, time_s

DESCRIPTION, STATED, TRUTH = "description.toml", "stated.json", "truth.json"


@dataclass(frozen=True)
class Form:
    """How a table is saved. header: units (in the names), names or none. timed: with a column of times."""

    mat: bool
    separator: str
    comma: bool
    header: str
    timed: bool

    @property
    def name(self) -> str:
        return "log.mat" if self.mat else "log.csv"


def form_of(case: Case) -> Form:
    chance = luck(case.rig.seed, 22)
    separator = str(chance.choice([",", ";", "\t", " "], p=[0.45, 0.3, 0.15, 0.1]))
    comma = separator in (";", "\t") and chance.random() < 0.4
    header = str(chance.choice(["units", "names", "none"], p=[0.5, 0.3, 0.2]))
    return Form(bool(chance.random() < 0.25), separator, comma, header, bool(chance.random() < 0.85))


def write_case(case: Case, folder: Path) -> None:
    """Write the table, its description, the stated rig if there is one, and the truth; `folder` is made."""
    folder.mkdir(parents=True, exist_ok=True)
    form, told_columns = form_of(case), columns(case)
    if form.mat:
        names = _write_mat(folder / form.name, case, told_columns, form)
    else:
        names = _write_csv(folder / form.name, case, told_columns, form)
    (folder / DESCRIPTION).write_text(_description(case, told_columns, names, form))
    if case.rig.stated:
        (folder / STATED).write_text(json.dumps(nominal(case.rig), indent=1) + "\n")
    (folder / TRUTH).write_text(json.dumps(truth(case), indent=1) + "\n")


def nominal(rig: Rig) -> dict[str, object]:
    """The rig as its data sheets state it: all that a model file needs, SI, referred to the joint."""
    drive = rig.drive
    return {
        "arm": {"length_m": rig.arm.length_m, "clamped_modes": rig.arm.clamped_modes()},
        "drive": {
            "kind": drive.kind,
            "inertia_kg_m2": rig.inertia,
            "motor_inertia_kg_m2": drive.motor_inertia,
            "torque_per_command_n_m": drive.gain,
            "back_emf_n_m_s": drive.back_emf,
            "viscous_n_m_s": drive.viscous,
            "gear_ratio": drive.gear_ratio,
            "lag_s": drive.lag_s,
            "limit": drive.limit,
            "command_per_logged_unit": drive.log_size,
        },
        "channels": [
            {
                "kind": c.kind,
                "unit": c.unit,
                "si_per_unit": c.size,
                "noise": c.noise,
                "quantum": c.quantum,
                "bias": c.bias,
            }
            for c in rig.channels
        ],
        "cycle_s": 1.0 / rig.rate_hz,
    }


def truth(case: Case) -> dict[str, object]:
    """truth.json. size_in_noise: rms of what the effect changes, over the noise, in the channel where it is largest."""
    rig, effect = case.rig, case.effect
    return {
        "expected": "none" if effect is None else "named",
        "cause": None if effect is None else effect.cause,
        "form": None if effect is None else effect.form,
        "parameters": {} if effect is None else told(rig, effect),
        "size_in_noise": case.shows,
        "size_is_against": "the stated rig"
        if effect and CAUSES[effect.cause].stated
        else "a refit of the rig's own parameters",
        "seen": case.seen,
        "seen_without_refit": case.raw,
        "relative_size": case.relative,
        "relative_to": CAUSES[effect.cause].unit if effect else "",
        "seed": rig.seed,
        "stated": rig.stated,
        "nominal": nominal(rig),
        "arm": asdict(rig.arm),
        "rate_hz": rig.rate_hz,
        "duration_s": rig.duration_s,
        "excitation": rig.excitation.kind,
        "closed_loop": rig.excitation.closed,
        "gains": {"kp": rig.excitation.kp, "kd": rig.excitation.kd},
    }


def _write_csv(path: Path, case: Case, of: list[Column], form: Form) -> list[str]:
    """Names of the columns as an importer finds them: the time's first, empty where there is none."""
    times = [time_s(case)] if form.timed else []
    shown = [*times, *(c.values for c in of)]
    formats = [*["%.6f"] * len(times), *("%.0f" if c.whole else "%.7g" for c in of)]
    head = [*["time [s]"] * len(times), *(f"{c.name} [{c.printed}]" for c in of)]
    if form.header == "names":
        head = [*["t"] * len(times), *(c.name for c in of)]
    if form.separator == " ":
        head = [name.replace(" ", "_") for name in head]
    table = np.stack(shown, axis=1)
    lines = [form.separator.join(formats) % tuple(row) for row in table.tolist()]
    if form.comma:
        lines = [line.replace(".", ",") for line in lines]
    path.write_text(
        "\n".join([*([form.separator.join(head)] if form.header != "none" else []), *lines]) + "\n"
    )
    found = [f"column {k + 1}" for k in range(len(shown))] if form.header == "none" else head
    return found if form.timed else ["", *found]


def _write_mat(path: Path, case: Case, of: list[Column], form: Form) -> list[str]:
    """One matrix, as students save it; dated by nothing, so that the same case gives the same bytes."""
    times = [time_s(case)] if form.timed else []
    table = np.stack([*times, *(np.round(c.values) if c.whole else c.values for c in of)], axis=1)
    savemat(path, {"data": table})
    data = path.read_bytes()
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(116) + data[116:])
    found = [f"data(:,{k + 1})" for k in range(table.shape[1])]
    return found if form.timed else ["", *found]


def _description(case: Case, of: list[Column], names: list[str], form: Form) -> str:
    """docs/import.md: what a careful user would have corrected it to."""
    lines = [f'source = "{form.name}"', "", "[[tables]]", f'time_column = "{names[0]}"']
    lines.append('time_unit = "s"' if names[0] else f"rate_hz = {case.rig.rate_hz!r}")
    for column, name in zip(of, names[1:], strict=True):
        lines += ["", "[[tables.channels]]", f'column = "{name}"', f'role = "{column.role}"']
        lines += [f'unit = "{column.unit}"'] if column.unit else []
        lines += [f"scale = {column.scale!r}"] if column.scale is not None else []
    return "\n".join(lines) + "\n"
