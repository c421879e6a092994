"""`stillarm recover`: repairs a cut recording."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("recording", type=Path, metavar="REC", help="recording (MCAP), cut or damaged")
    parser.add_argument(
        "-o",
        "--out",
        type=Path,
        metavar="REC",
        help="repaired recording to write (default: NAME.recovered.mcap)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Repair the recording, and report what was kept."""
    from stillarm.common.recording.recover import recover
    from stillarm.progress import progress_bar

    out = arguments.out or arguments.recording.with_suffix(".recovered.mcap")
    with progress_bar(f"recover {arguments.recording.name}"):
        report = recover(arguments.recording, out)
    state = "was cut" if report.cut else "was complete"
    kept = ", ".join(f"{topic} {count}" for topic, count in report.messages.items())
    print(
        f"{out}: the recording {state}, with {report.damaged} damaged stretches; messages kept: {kept or 'none'}"
    )
    if report.left_out:
        print(f"left out, not written by this program: {', '.join(report.left_out)}")
    return 0
