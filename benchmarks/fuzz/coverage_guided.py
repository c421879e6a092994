"""Coverage-guided fuzzing with atheris: `python -m stillarm.benchmarks.fuzz.coverage_guided datagram
-max_total_time=60`.

Options after the target are libFuzzer's; a folder among them is the corpus. Install with `pip install stillarm[fuzz]`.
"""

import sys

from stillarm.common.user_error import UserError


def main(words: list[str]) -> int:
    """Fuzz until there is a finding, which libFuzzer writes to a file, or until its limits are reached."""
    try:
        import atheris
    except ImportError:
        print(
            "stillarm.benchmarks.fuzz: atheris is missing; install it with `pip install stillarm[fuzz]`",
            file=sys.stderr,
        )
        return 1
    with atheris.instrument_imports(include=["common", "controller", "drivers", "supervisor"]):
        from stillarm.benchmarks.fuzz.targets import TARGETS
    if not words or words[0] not in TARGETS:
        print(f"stillarm.benchmarks.fuzz: name a target: {', '.join(TARGETS)}", file=sys.stderr)
        return 1
    atheris.Setup([sys.argv[0], *words[1:]], TARGETS[words[0]])
    atheris.Fuzz()
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except UserError as error:
        sys.exit(str(error))
