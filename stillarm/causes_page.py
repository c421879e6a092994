"""The causes' declarations as text for people and as a JSON schema; makes docs/causes.md."""

from collections.abc import Mapping
from math import isnan
from typing import Any

from stillarm.common.causes import CAUSES, Cause, Parameter, experiment_between
from stillarm.common.causes.declaration import SEPARATES
from stillarm.common.causes.driven import DRIVEN_CAUSES, DrivenCause

ALL_CAUSES: Mapping[str, Cause | DrivenCause] = {**CAUSES, **DRIVEN_CAUSES}
"""Both catalogues by identifier; they share no name."""
DRIVEN = "driven joint"
"""Where the causes of the second catalogue act, as a list has it."""

_HEAD = """# Causes: how a rig departs from its model

Each is a named extension of the simulation. A model file takes any number of them, each at most once unless it says
*may be repeated*:

```toml
[[effects]]
cause = "cubic_stiffness"
coefficient_per_m2 = 300.0
```

`stillarm simulate --model FILE` and the rig of the demo then obey it. The controller and `replay` also take up
second_bending_mode and the causes that are another value of a model key ("replaces"); they say once which of the others
they make no use of. All that the program knows of a cause stands in one file of `common/causes/`, and this page is made
from those files (`stillarm causes --markdown`). `stillarm causes NAME` prints one of them, `stillarm causes --schema`
the JSON schema of an entry.

t is time from the recording's start; for the live rig, from the first drive command, which is within a cycle or two of
it. A cause of the arm sets in at its onset, one of the images on the first exposure at or after it. An effect of no
size changes nothing, to the last bit, and no effect changes the random numbers of the rest (a second mode alone takes
its own share of a random disturbance): runs with and without it, from one seed, can be compared sample by sample.

`stillarm demo --hide SEED` draws a cause, its size and its sign from the usual ranges below and puts it into the rig
alone, with moves of the joint that make it show. Only truth.mcap says what it was (`stillarm export truth.mcap -o DIR`
writes its model.toml).

A closed damping loop hides what the arm does by itself: for the arm's causes record with damping off.
"""

_DRIVEN_HEAD = """## The joint that a torque, a current or a voltage drives

`stillarm diagnose` names these where such an input was recorded ([measured-rigs.md](measured-rigs.md)), and states
them in extended.toml. `simulate` and the rig obey those between the input and the joint (friction, ripple, gravity,
offset, dead zone) where the model states such a joint, and refuse the others in one line. theta is the joint's angle;
all torques are divided by the hub's inertia. gear_backlash, drive_saturation, coulomb_damping, cubic_stiffness and
accelerometer_lag, above, are named there as well.
"""
_TELLS_APART = (
    "move the joint to and fro at several constant speeds, slow ones too, and let it rest in several places"
)

_PLACES = {
    "arm": "The arm",
    "drive": "The drive",
    "accelerometer": "The accelerometer",
    "camera": "The image",
    "timing": "Timing",
}


def page() -> str:
    """The whole of docs/causes.md."""
    parts = [_HEAD]
    for place, title in _PLACES.items():
        parts.append(f"## {title}\n")
        parts += [section(cause) for cause in CAUSES.values() if cause.place == place]
    parts.append(_DRIVEN_HEAD)
    parts += [section(cause) for cause in DRIVEN_CAUSES.values()]
    return "\n".join(parts)


def place_of(cause: Cause | DrivenCause) -> str:
    """Where a cause acts, in a word or two."""
    return cause.place if isinstance(cause, Cause) else DRIVEN


def section(cause: Cause | DrivenCause) -> str:
    """All that is said of one cause."""
    note = cause.note if isinstance(cause, Cause) else ""
    told = f"{cause.sees[0].upper()}{cause.sees[1:]}. {note}".strip()
    lines = [f"### {cause.identifier}", "", told + (" *May be repeated.*" if cause.repeatable else ""), ""]
    lines += [f"    {cause.equation}", ""]
    lines += [f"- `{one.name}`: {_allowed(one)}" for one in cause.parameters]
    lines += ["", f"To provoke it: {cause.provoke}", ""]
    lines += [f"To tell it from {other}: {how}." for other, how in _separated(cause).items()] or [
        f"To tell it from others: {SEPARATES[cause.place] if isinstance(cause, Cause) else _TELLS_APART}."
    ]
    return "\n".join([*lines, ""])


def _separated(cause: Cause | DrivenCause) -> dict[str, str]:
    """Experiments that tell a cause from those that it is easily confused with."""
    if isinstance(cause, DrivenCause):
        said_there = {
            name: other.confused_with[cause.identifier]
            for name, other in DRIVEN_CAUSES.items()
            if cause.identifier in other.confused_with
        }
        return {**cause.confused_with, **said_there}
    between = {
        other: experiment_between(cause.identifier, other) for other in CAUSES if other != cause.identifier
    }
    return {other: how for other, how in between.items() if how is not None}


def _allowed(parameter: Parameter) -> str:
    left_out = "" if parameter.default is None else f"; {_said(parameter.default)} when left out"
    if parameter.default == "":
        left_out = "; all of them when left out"
    if parameter.kind == "truth":
        return f"true or false{left_out}"
    if parameter.kind == "text":
        return " or ".join(f'"{choice}"' for choice in parameter.choices) + left_out
    low, high = parameter.typical
    usual = f"; usually {low:g} to {high:g}" if high > 0.0 and not left_out else ""
    if usual and parameter.neutral == 1.0:
        usual += " off 1"
    if usual and parameter.signed:
        usual += ", of either sign"
    return f"{parameter.unit}, {parameter.lowest:g} to {parameter.highest:g}{usual}{left_out}"


def _said(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and isnan(value):
        return "as the rig shows it"
    return f"{value:g}" if isinstance(value, int | float) else f'"{value}"'


def schema() -> dict[str, Any]:
    """JSON schema of one entry of [[effects]] in a model file."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "effect",
        "oneOf": [_schema_of(cause) for cause in ALL_CAUSES.values()],
    }


def _schema_of(cause: Cause | DrivenCause) -> dict[str, Any]:
    properties: dict[str, Any] = {"cause": {"const": cause.identifier}}
    for one in cause.parameters:
        if one.kind == "truth":
            properties[one.name] = {"type": "boolean"}
        elif one.kind == "text":
            properties[one.name] = {"enum": list(one.choices)}
        else:
            kind = "integer" if one.kind == "whole" else "number"
            properties[one.name] = {"type": kind, "minimum": one.lowest, "maximum": one.highest}
            properties[one.name]["description"] = one.unit
        shown_by_the_rig = isinstance(one.default, float) and isnan(one.default)  # no number that JSON has
        if one.default is not None and not shown_by_the_rig and one.default != "":
            properties[one.name]["default"] = one.default
    return {
        "type": "object",
        "description": cause.sees,
        "properties": properties,
        "required": ["cause", *(one.name for one in cause.parameters if one.default is None)],
        "additionalProperties": False,
    }
