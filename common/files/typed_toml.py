"""TOML files read into typed structures, with errors that name file, key, value, bound and the nearest key.

msgspec reads and checks. When it refuses, this module searches the tree for the first value that does not fit, because
msgspec's message names no value, no choices, no nearest key, and no key of a table whose keys are free.
"""

import difflib
import math
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

import msgspec

from stillarm.common.user_error import UserError, reason_of

Structure = TypeVar("Structure")
Key = str | int

_BYTE_ORDER_MARK = "\ufeff"  # some editors begin a file with it
_BARE = re.compile(r"[A-Za-z0-9_-]+")  # a TOML key without quotes


def read_toml_text(path: str | Path) -> str:
    """A TOML file's text as it stands there. Raises UserError, one line."""
    try:
        return Path(path).read_bytes().decode("utf-8")
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({reason_of(error)}); name an existing TOML file") from None
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: not UTF-8 text at byte {error.start}; save it as UTF-8") from None


def load_toml(path: str | Path, structure: type[Structure]) -> Structure:
    """Read a TOML file as `structure` (a msgspec Struct that forbids unknown fields).

    Raises UserError, one line, for a file that cannot be read, is no TOML, or does not fit the structure.
    """
    return parse_toml(read_toml_text(path), structure, str(path))


def parse_toml(text: str, structure: type[Structure], name: str) -> Structure:
    """Read TOML text as `structure`; `name` stands for the file in error messages."""
    try:
        tree = tomllib.loads(text.removeprefix(_BYTE_ORDER_MARK))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise UserError(f"{name}: not valid TOML: {_one_line(str(error))}") from None
    return convert_tree(tree, structure, name)


def convert_tree(tree: dict[str, Any], structure: type[Structure], name: str) -> Structure:
    """Check a tree of plain values against `structure`; `name` stands for the file in error messages."""
    for keys, value in _leaves(tree, []):
        if isinstance(value, float) and not math.isfinite(value):
            raise UserError(f"{name}: {_join(keys)} = {value}: a finite number is needed")
    try:
        return msgspec.convert(tree, structure)
    except msgspec.ValidationError as error:
        raise UserError(f"{name}: {_misfit(tree, structure, []) or _one_line(str(error))}") from None


def _misfit(value: Any, kind: Any, keys: list[Key]) -> str | None:
    """The first thing in `value` that is not of type `kind`: its key, its value, what is allowed. None if all fits."""
    inner = _inner(kind)
    parts: list[tuple[Key, Any]] = []
    if isinstance(inner, type) and issubclass(inner, msgspec.Struct) and isinstance(value, dict):
        fields = {field.encode_name: field for field in msgspec.structs.fields(inner)}
        for key in value:
            if key not in fields:
                return _unknown(value[key], [*keys, key], list(fields))
        for key, field in fields.items():
            if field.required and key not in value:
                return f"{_join([*keys, key])}: required key is missing; add it"
        parts = [(key, fields[key].type) for key in value]
    elif get_origin(inner) is dict and isinstance(value, dict):
        parts = [(key, get_args(inner)[1]) for key in value]
    elif get_origin(inner) in (list, tuple) and isinstance(value, list):
        parts = [(index, get_args(inner)[0]) for index in range(len(value))]
    for key, part in parts:
        if found := _misfit(value[key], part, [*keys, key]):
            return found
    try:
        msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        choices = " or ".join(map(_toml, sorted(get_args(inner)))) if get_origin(inner) is Literal else ""
        problem = f"not one of the choices; use {choices}" if choices else _one_line(str(error))
        return f"{_join(keys)} = {_shorten(value)}: {problem}"
    return None


def _inner(kind: Any) -> Any:
    """A type without its bounds, and without its being optional."""
    if get_origin(kind) is Annotated:
        return _inner(get_args(kind)[0])
    if get_origin(kind) in (Union, UnionType):
        there = [member for member in get_args(kind) if member not in (NoneType, msgspec.UnsetType)]
        return _inner(there[0]) if len(there) == 1 else kind
    return kind


def _unknown(value: Any, keys: list[Key], allowed: list[str]) -> str:
    near = difflib.get_close_matches(str(keys[-1]), allowed, n=1, cutoff=0.0)
    nearest = f"; the nearest valid key is {_join([*keys[:-1], near[0]])}" if near else ""
    return f"{_join(keys)} = {_shorten(value)}: unknown key{nearest}; delete or rename it"


def _toml(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


def _join(keys: list[Key]) -> str:
    text = ""
    for key in keys:
        one = f"[{key}]" if isinstance(key, int) else key if _BARE.fullmatch(key) else f'"{key}"'
        text += f".{one}" if text and not isinstance(key, int) else one
    return text or "(file)"


def _leaves(tree: Any, keys: list[Key]) -> Iterator[tuple[list[Key], Any]]:
    if isinstance(tree, dict | list):
        for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from _leaves(value, [*keys, key])
    else:
        yield keys, tree


def _shorten(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _one_line(text: str) -> str:
    text = " ".join(text.split())
    return text[:1].lower() + text[1:]
