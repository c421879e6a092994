"""reference/python.md, from the docstrings of what `import stillarm` offers."""

import inspect
import re
from dataclasses import is_dataclass
from typing import Any

import stillarm

_HEAD = """# Python

    import stillarm

The import alone loads nothing; each name is loaded when it is used. Mistakes raise `stillarm.UserError`,
whose text is one line. This page is made from the docstrings.

"""
_FIRST = ("load", "replay", "simulate", "diagnose", "Model", "with_sine_prediction")


def page() -> str:
    """The whole page: what one calls, then the types."""
    others = sorted(set(stillarm._FROM) - set(_FIRST))
    return _HEAD + "\n".join(section(name) for name in (*_FIRST, *others))


def section(name: str) -> str:
    """One name: signature, docstring, and a class's own public parts."""
    thing = getattr(stillarm, name)
    lines = [f"## {name}", ""]
    if inspect.isclass(thing) or callable(thing):
        lines += [f"    {row}" for row in _wrapped(f"stillarm.{name}{_signature(thing)}")] + [""]
    lines += [_text(thing), ""]
    if inspect.isclass(thing):
        lines += [_member(part, value) for part, value in _parts(thing)]
    return "\n".join(lines) + "\n"


def _wrapped(call: str) -> list[str]:
    """A signature in one line, or with a line for each argument where it is long."""
    if len(call) < 90 or "(" not in call:
        return [call]
    begin, _, rest = call.partition("(")
    inside, end = rest[: rest.rindex(")")], rest[rest.rindex(")") :]
    rows, depth = [""], 0
    for letter in inside:
        depth += (letter in "[(") - (letter in "])")
        if letter == "," and depth == 0:
            rows.append("")
        else:
            rows[-1] += letter
    return [f"{begin}(", *(f"    {row.strip()}," for row in rows), end]


def _parts(thing: type) -> list[tuple[str, Any]]:
    """Methods and properties with a docstring of their own, in the order of the code."""
    return [
        (name, value)
        for name, value in vars(thing).items()
        if not name.startswith("_")
        and (callable(value) or isinstance(value, property | classmethod) or hasattr(value, "func"))
        and _text(value)
        and not inspect.isclass(value)
    ]


def _member(name: str, value: Any) -> str:
    called = value.__func__ if isinstance(value, classmethod) else value
    signature = _signature(called) if callable(called) else ""
    return f"- **{name}**`{signature}`: {_text(value)}" if signature else f"- **{name}**: {_text(value)}"


def _signature(thing: Any) -> str:
    try:
        text = str(inspect.signature(thing))
    except (TypeError, ValueError):
        return ""
    if is_dataclass(thing) or not inspect.isclass(thing):
        text = re.sub(r"<function .*? at 0x[0-9a-f]+>", "...", text)  # a default that is a function
        text = re.sub(r"(: |-> )'([^']*)'", r"\1\2", text)  # annotations that are quoted in the code
        return re.sub(r"(stillarm|collections|pathlib)\.[\w.]*?(?=\w+\b(?!\.))", "", text)
    return ""


def _text(thing: Any) -> str:
    """The docstring as one paragraph for each of its own."""
    found = inspect.getdoc(getattr(thing, "func", thing)) or ""
    return "\n\n".join(" ".join(part.split()) for part in found.split("\n\n") if not part.startswith("    "))
