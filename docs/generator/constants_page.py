"""reference/constants.md: every number that the diagnosis stands on, with what its module says of it."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from stillarm.common.datagrams.fields import markdown_table

_ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("data", "physics", "fitting", "events", "sensors", "forms", "search", "decision", "driven")
"""Of diagnosis/: what lies between a recording and its verdict."""
_HEAD = """# Constants of the diagnosis

Numbers in diagnosis/ that are neither measured in the recording nor read from the model file: {count} of them, by
module. Each is shown with what its module says of it: its unit, and where it comes from. Tolerances of a search are
among them: how many steps, how fine. This page is made from the code.

"""


@dataclass(frozen=True)
class Constant:
    """A number of a module. about: what the module says of it, empty where it says nothing."""

    module: str
    name: str
    value: str
    about: str


def page() -> str:
    """The whole page."""
    found = list(constants())
    parts = [_HEAD.format(count=len(found))]
    for module in dict.fromkeys(one.module for one in found):
        rows = [(f"`{one.name}`", f"`{one.value}`", one.about) for one in found if one.module == module]
        parts.append(f"## {module}\n")
        parts.append(markdown_table(("name", "value", "about"), rows))
    return "\n".join(parts)


def constants() -> Iterator[Constant]:
    """Every constant, module by module."""
    for package in PACKAGES:
        for path in sorted((_ROOT / "diagnosis" / package).rglob("*.py")):
            yield from _of_module(path)


def _of_module(path: Path) -> Iterator[Constant]:
    text = path.read_text(encoding="utf-8")
    lines, body = text.splitlines(), ast.parse(text).body
    name = path.relative_to(_ROOT).as_posix()
    for place, node in enumerate(body):
        after = body[place + 1] if place + 1 < len(body) else None
        about = _docstring(after) or _comment(lines, node)
        for target, value in _assigned(node):
            if target.isupper() and _is_number(value):
                yield Constant(name, target, " ".join(ast.unparse(value).split()), about)


def _assigned(node: ast.stmt) -> Iterator[tuple[str, ast.expr]]:
    """Names and what they are set to, also of `A, B = 1, 2`."""
    if not isinstance(node, ast.Assign) or len(node.targets) != 1:
        return
    target, value = node.targets[0], node.value
    if isinstance(target, ast.Name):
        yield target.id, value
    elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        for one, each in zip(target.elts, value.elts, strict=True):
            if isinstance(one, ast.Name):
                yield one.id, each


def _is_number(value: ast.expr) -> bool:
    """Whether a number is written there, alone or within a tuple, a table or a formula."""
    inner = [one.value for one in ast.walk(value) if isinstance(one, ast.Constant)]
    of_text = any(isinstance(one, str | bool) for one in inner) and not isinstance(value, ast.Dict)
    makes = isinstance(value, ast.Call) and not _is_formula(value.func)
    return not (of_text or makes) and any(type(one) in (int, float) for one in inner)


def _is_formula(function: ast.expr) -> bool:
    """Whether a call computes a number, rather than make an object."""
    return ast.unparse(function).startswith(("np.", "log", "sqrt", "frozenset"))


def _docstring(node: ast.stmt | None) -> str:
    if (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    ):
        return " ".join(node.value.value.split())
    return ""


def _comment(lines: list[str], node: ast.stmt) -> str:
    """The comment behind a statement, or those right above it."""
    assert node.end_lineno is not None
    for line in lines[node.lineno - 1 : node.end_lineno]:
        _, mark, said = line.partition("  # ")
        if mark and not said.startswith(("fmt:", "noqa")):
            return said.strip()
    above: list[str] = []
    for line in reversed(lines[: node.lineno - 1]):
        if not line.startswith("# "):
            break
        above.insert(0, line.removeprefix("# ").strip())
    return " ".join(above)
