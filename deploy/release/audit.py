"""What databases of known vulnerabilities say of an installation, asked by pip-audit.

A package that no database could be asked about is not clean: it is not audited, and the release says so.
"""

import json
import subprocess
from pathlib import Path
from typing import Any

SERVICES = (
    "pypi",
    "osv",
)  # PyPI's index and its origin, https://osv.dev: where one does not answer, the other may
OWN = ("stillarm", "stillarm-complete")  # what is being released, which no database can know


def asked(packages: Path, service: str) -> list[dict[str, Any]]:
    """pip-audit's answer for each package of a folder of packages; none where the service does not answer."""
    words = ("pip-audit", "--path", packages, "--vulnerability-service", service, "--format", "json")
    done = subprocess.run([*words, "--progress-spinner", "off"], capture_output=True, text=True, check=False)
    try:
        return list(json.loads(done.stdout)["dependencies"])
    except (ValueError, KeyError):
        return []


def installed(packages: Path) -> list[str]:
    """The packages of a folder of packages, by their metadata, without our own."""
    names = {
        path.name.removesuffix(".dist-info").rpartition("-")[0].lower().replace("_", "-")
        for path in packages.glob("*.dist-info")
    }
    return sorted(names - set(OWN))


def verdict(names: list[str], answers: dict[str, list[dict[str, Any]]]) -> tuple[bool, list[str]]:
    """Whether every package was looked up and is clean, and what to print. answers: of each service, `asked()`."""
    looked_up: set[str] = set()
    lines: list[str] = []
    for service, answer in answers.items():
        for one in answer:
            if "skip_reason" in one:
                continue
            looked_up.add(one["name"].lower().replace("_", "-"))
            for found in one["vulns"]:
                mended = ", ".join(found.get("fix_versions", [])) or "no version yet"
                lines.append(f"{one['name']} {one['version']}: {found['id']} ({service}); mended in {mended}")
    if unknown := [name for name in names if name not in looked_up]:
        services = " nor ".join(answers)
        lines.append(
            f"NOT AUDITED: neither {services} answers for {len(unknown)} of {len(names)} packages "
            f"({', '.join(unknown)}); build where one of them can be reached, or say --no-audit"
        )
    return not lines, lines or [f"audited: {len(names)} packages, no known vulnerability"]


def audit(packages: Path) -> tuple[bool, list[str]]:
    """Ask all services about the packages of a folder; `verdict()`."""
    return verdict(installed(packages), {service: asked(packages, service) for service in SERVICES})
