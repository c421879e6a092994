"""A contract for import-linter: from outside a package, only the modules are imported that its `__all__` names.

`__all__` in an `__init__` lists submodules and subpackages. A package without it has no interface to hold;
each subpackage
of the packages in WITH_INTERFACES must have one.
"""

import ast
from functools import cache
from pathlib import Path

from grimp import ImportGraph
from importlinter import Contract, ContractCheck, output

ROOT = Path(__file__).parents[2]
WITH_INTERFACES = (
    "common",
    "drivers",
    "controller",
    "supervisor",
    "simulation",
    "diagnosis",
    "panel",
    "tables",
)


@cache
def interface_of(package: str) -> frozenset[str] | None:
    """Names in a package's `__all__`; None where it has none, or is no package."""
    file = ROOT.joinpath(*package.split("."), "__init__.py")
    if not file.is_file():
        return None
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, ast.Assign) and [ast.unparse(target) for target in node.targets] == ["__all__"]:
            return frozenset(ast.literal_eval(node.value))
    return None


def crossings(importer: str, imported: str) -> list[tuple[str, str]]:
    """The packages whose border an import crosses inwards, each with the name in it that is imported.

    `a.b.x` imports `a.c.d.y`: it crosses into a.c for d, and into a.c.d for y.
    """
    found = []
    parts = imported.split(".")
    for depth in range(1, len(parts)):
        package = ".".join(parts[:depth])
        if importer != package and not importer.startswith(f"{package}."):
            found.append((package, parts[depth]))
    return found


class InterfaceContract(Contract):
    """Holds every `__all__` of the graph's packages."""

    type_name = "interface"

    def check(self, graph: ImportGraph, verbose: bool) -> ContractCheck:
        """Compare all imports with the interfaces."""
        del verbose
        modules = sorted(name for name in graph.modules if not graph.is_module_squashed(name))
        wrong = []
        for name in modules:
            parts = name.split(".")
            is_package = ROOT.joinpath(*parts, "__init__.py").is_file()
            if is_package and len(parts) > 2 and parts[1] in WITH_INTERFACES and interface_of(name) is None:
                wrong.append(f"{name} has no __all__ that says what others may import")
            for imported in graph.find_modules_directly_imported_by(name):
                for package, part in crossings(name, imported):
                    interface = interface_of(package)
                    if interface is not None and part not in interface:
                        wrong.append(f"{name} imports {imported}; {package}.__all__ does not name {part}")
        return ContractCheck(kept=not wrong, metadata={"wrong": sorted(set(wrong))})

    def render_broken_contract(self, check: ContractCheck) -> None:
        """One line for each."""
        for line in check.metadata["wrong"]:
            output.print_error(f"- {line}", bold=False)
