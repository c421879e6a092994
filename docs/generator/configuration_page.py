"""reference/configuration.md, from the declarations of the three kinds of files: each key, its bounds, its default."""

from collections.abc import Iterator
from typing import Any, Literal, get_args, get_origin, get_type_hints

import msgspec
from msgspec import Meta

from stillarm.common.datagrams.fields import markdown_table, unit_of
from stillarm.common.files.configuration import Configuration
from stillarm.common.files.model import Model
from stillarm.common.files.scenario import Scenario

_HEAD = """# Configuration, model, scenario

Three kinds of TOML file. A key that is left out takes its default; an unknown key is refused with the nearest known
one. Units are in the keys' names. This page is made from the declarations that read the files.

"""
_FILES = {"The configuration": Configuration, "The model file": Model, "The scenario": Scenario}


def page() -> str:
    """The whole page."""
    parts = [_HEAD]
    for title, kind in _FILES.items():
        parts += [f"## {title}\n", *_sections(kind, "")]
    return "\n".join(parts)


def _sections(kind: type[msgspec.Struct], name: str) -> Iterator[str]:
    """A section with its keys, then those inside it."""
    hints = get_type_hints(kind, include_extras=True)
    text = " ".join((kind.__doc__ or "").split())
    inner, rows = [], []
    for field in msgspec.structs.fields(kind):
        hint = hints[field.name]
        struct, many = _struct_in(hint)
        if struct is not None:
            inner.append((struct, f"{name}.{field.name}".lstrip("."), many))
        else:
            rows.append((f"`{field.name}`", _allowed(hint), unit_of(field.name), _default(field)))
    yield f"### {_title(name)}\n\n{text}\n"
    if rows:
        yield markdown_table(("key", "allowed", "unit", "default"), rows)
    for struct, inside, many in inner:
        yield from _sections(struct, f"[{inside}]" if many else inside)


def _title(name: str) -> str:
    return f"`[{name}]`" if name else "At the top"


def _struct_in(hint: Any) -> tuple[type[msgspec.Struct] | None, bool]:
    """The section that a key's type is or lists, and whether there may be several."""
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        return hint, False
    many = get_origin(hint) is list
    for inside in get_args(hint):
        struct, more = _struct_in(inside)
        if struct is not None:
            return struct, many or more
    return None, False


def _allowed(hint: Any) -> str:
    """What a key may be: its type, choices and bounds."""
    base, notes = hint, []
    while get_origin(base) is not None and hasattr(base, "__metadata__"):
        notes += [note for note in base.__metadata__ if isinstance(note, Meta)]
        base = base.__origin__
    if get_origin(base) is Literal:
        return ", ".join(f"`{choice!r}`".replace("'", '"') for choice in get_args(base))
    bounds = [
        f"{sign} {value:g}"
        for note in notes
        for sign, value in ((">", note.gt), (">=", note.ge), ("<", note.lt), ("<=", note.le))
        if value is not None
    ]
    return ", ".join([_type_name(base), *bounds])


def _type_name(base: Any) -> str:
    plain = {float: "number", int: "whole number", str: "text", bool: "true or false"}
    if base in plain:
        return plain[base]
    inside = [_allowed(one) for one in get_args(base) if one not in (type(None), msgspec.UnsetType, Ellipsis)]
    if get_origin(base) in (list, tuple):
        return f"list of {'; '.join(dict.fromkeys(inside))}"
    if get_origin(base) is dict:
        return "table: [causes.md](../causes.md)"
    return " or ".join(inside) or str(base)


def _default(field: Any) -> str:
    if field.default_factory is not msgspec.NODEFAULT:
        value = field.default_factory()
    elif field.default is msgspec.NODEFAULT:
        return "required"
    else:
        value = field.default
    if value is None or value is msgspec.UNSET:
        return "absent"
    return f"`{msgspec.json.encode(value).decode()}`"
