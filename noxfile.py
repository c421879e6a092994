"""`nox`: the tests on each Python that the machine has; `nox -s lean`: the daemons without the heavy packages."""

import nox

nox.options.sessions = ["tests", "lean"]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")


@nox.session(python=PYTHONS, venv_backend="uv|venv")
def tests(session: nox.Session) -> None:
    """The quick tests from an installed tree; other words of pytest follow `--`."""
    session.install("--editable", ".[dev]")
    session.run("pytest", *(session.posargs or ["--quick", "-n", "2"]))


@nox.session(python=PYTHONS, venv_backend="uv|venv")
def lean(session: nox.Session) -> None:
    """The base install imports the controller, the supervisor's with OpenCV; neither brings a heavy package."""
    session.install(".[vision]")
    session.run("stillarm", "--version")
    session.run("python", "-c", "import stillarm.controller.loop.daemon, stillarm.supervisor.daemon")
    absent = (
        "from importlib.util import find_spec as f; assert not any(map(f, ('scipy', 'numba', 'matplotlib')))"
    )
    session.run("python", "-c", absent)
