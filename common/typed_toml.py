"""TOML files read into typed structures, with errors that name file, key, value, bound and the
nearest key.
"""

import difflib
import math
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from common.user_error import UserError

Structure = TypeVar("Structure")

_PATH = re.compile(r" - at `\$?(?P<path>[^`]*)`$")
_BYTE_ORDER_MARK = "\ufeff"  # some editors begin a file with it
_BARE = re.compile(r"[A-Za-z0-9_-]+")  # a TOML key without quotes
_SOME_KEY = "[...]"  # how msgspec names the key of a table whose keys are free
_UNKNOWN = re.compile(r"unknown field `(?P<field>[^`]*)`")


def load_toml(path: str | Path, structure: type[Structure]) -> Structure:
    """Read a TOML file as `structure` (a msgspec Struct that forbids unknown fields).

    Raises UserError, one line, for a file that cannot be read, is no TOML, or does not fit the structure.
    """
    path = Path(path)
    try:
        text = path.read_bytes().decode("utf-8")
    except OSError as error:
        reason = error.strerror or str(error)
        raise UserError(f"{path}: cannot be read ({reason.lower()}); name an existing TOML file") from None
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: not UTF-8 text at byte {error.start}; save it as UTF-8") from None
    return parse_toml(text, structure, str(path))


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
        raise UserError(_explain(str(error), tree, structure, name)) from None


def _explain(message: str, tree: dict[str, Any], structure: Any, name: str) -> str:
    match = _PATH.search(message)
    keys = _found(message, _split(match["path"]), tree, structure) if match else []
    problem = message[: match.start()] if match else message
    unknown = _UNKNOWN.search(problem)
    if unknown:
        allowed = _fields(structure, keys)
        key = _join([*keys, unknown["field"]])
        near = difflib.get_close_matches(unknown["field"], allowed, n=1, cutoff=0.0)
        value = _value_at(tree, [*keys, unknown["field"]])
        nearest = f"; the nearest valid key is {_join([*keys, near[0]])}" if near else ""
        return f"{name}: {key} = {_shorten(value)}: unknown key{nearest}; delete or rename it"
    missing = re.search(r"missing required field `([^`]*)`", problem)
    if missing:
        return f"{name}: {_join([*keys, missing[1]])}: required key is missing; add it"
    where = f"{name}: {_join(keys)} = {_shorten(_value_at(tree, keys))}"
    choices = _choices(structure, keys)
    if choices and problem.startswith("Invalid enum value"):
        return f"{where}: not one of the choices; use {' or '.join(map(_toml, choices))}"
    return f"{where}: {_one_line(problem).lower()}"


def _choices(structure: Any, keys: list[str | int]) -> list[Any]:
    """What a Literal at a place in the tree allows, sorted."""
    kind = _kind_at(structure, keys)
    kinds = kind.types if isinstance(kind, msgspec.inspect.UnionType) else [kind]
    return [value for k in kinds if isinstance(k, msgspec.inspect.LiteralType) for value in k.values]


def _fields(structure: Any, keys: list[str | int]) -> list[str]:
    """Names of the keys that are valid at a place in the tree."""
    kind = _inner(_kind_at(structure, keys), None)
    if isinstance(kind, msgspec.inspect.StructType):
        return [field.encode_name for field in kind.fields]
    return []


def _kind_at(structure: Any, keys: list[str | int]) -> Any:
    kind = msgspec.inspect.type_info(structure)
    for key in keys:
        kind = _inner(kind, key)
    return kind


def _inner(kind: Any, key: str | int | None) -> Any:
    inspect = msgspec.inspect
    if isinstance(kind, inspect.UnionType):
        kind = next(
            (t for t in kind.types if isinstance(t, inspect.StructType | inspect.ListType)), kind.types[0]
        )
    if key is None:
        return kind
    if isinstance(kind, inspect.StructType):
        return next((f.type for f in kind.fields if f.encode_name == key), None)
    if isinstance(kind, inspect.ListType | inspect.VarTupleType):
        return kind.item_type
    return None


def _split(path: str) -> list[str | int]:
    return [
        int(part[1:-1]) if part.startswith("[") and part != _SOME_KEY else part
        for part in re.findall(r"\[[^\]]*\]|[^.\[\]]+", path)
    ]


def _found(message: str, keys: list[str | int], tree: Any, structure: Any) -> list[str | int]:
    """The keys with a table's own key where msgspec's message only says that there is one."""
    found: list[str | int] = []
    for key in keys:
        table = _value_at(tree, found)
        named = key != _SOME_KEY or not isinstance(table, dict)
        found.append(key if named else _refused(message, found, tree, structure))
    return found


def _refused(message: str, keys: list[str | int], tree: Any, structure: Any) -> str:
    """The key of the table at `keys` that is refused with that message, the table's others aside."""
    for key, value in _value_at(tree, keys).items():
        try:
            msgspec.convert(_with(tree, keys, {key: value}), structure)
        except msgspec.ValidationError as error:
            if str(error) == message:
                return str(key)
    return _SOME_KEY


def _with(tree: Any, keys: list[str | int], value: Any) -> Any:
    """A tree with another value at `keys`."""
    if not keys:
        return value
    copy = tree.copy()
    copy[keys[0]] = _with(tree[keys[0]], keys[1:], value)
    return copy


def _toml(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


def _join(keys: list[str | int]) -> str:
    text = ""
    for key in keys:
        one = f"[{key}]" if isinstance(key, int) else key if _BARE.fullmatch(key) else f'"{key}"'
        text += f".{one}" if text and not isinstance(key, int) else one
    return text or "(file)"


def _value_at(tree: Any, keys: list[str | int]) -> Any:
    for key in keys:
        try:
            tree = tree[key]
        except (KeyError, IndexError, TypeError):
            return None
    return tree


def _leaves(tree: Any, keys: list[str | int]) -> Iterator[tuple[list[str | int], Any]]:
    if isinstance(tree, dict | list):
        for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from _leaves(value, [*keys, key])
    else:
        yield keys, tree


def _shorten(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _one_line(text: str) -> str:
    return " ".join(text.split())
