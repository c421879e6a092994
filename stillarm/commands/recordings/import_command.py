"""`stillarm import`: converts measured data into a recording."""

import argparse
from pathlib import Path

from stillarm.common.user_error import UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "source", type=Path, metavar="DIR", help="CSV bundle (a folder), or with --map one data file"
    )
    parser.add_argument(
        "-o", "--out", type=Path, required=True, metavar="REC", help="recording to write (MCAP)"
    )
    parser.add_argument(
        "--map",
        action="append",
        default=[],
        metavar="NAME=COLUMN",
        help="input=COLUMN and output=COLUMN, by name or number",
    )
    parser.add_argument("--rate-hz", type=float, metavar="HZ", help="sampling rate of a mapped file")


def run(arguments: argparse.Namespace) -> int:
    """Import, and report what was imported."""
    for line in _mapped(arguments) if arguments.map else _bundle(arguments):
        print(line)
    return 0


def _bundle(arguments: argparse.Namespace) -> list[str]:
    from stillarm.common.csv_bundle.bundle_import import import_bundle

    report = import_bundle(arguments.source, arguments.out)
    model = "its own model.toml" if report.model_given else "no model.toml: every key at its default"
    lines = [f"{arguments.out}: {report.fast_rows} cycles, {report.frame_rows} frames, {model}"]
    if report.not_measured:
        lines.append(f"not measured: {', '.join(report.not_measured)}")
    if report.unknown:
        lines.append(f"unknown, kept: {', '.join(report.unknown)}")
    return [*lines, *report.notes]


def _mapped(arguments: argparse.Namespace) -> list[str]:
    from stillarm.common.csv_bundle.mapped_data import import_mapped

    if arguments.rate_hz is None:
        raise UserError("--rate-hz: needed with --map; give the sampling rate in samples a second")
    report = import_mapped(arguments.source, _mapping(arguments.map), arguments.rate_hz, arguments.out)
    return [
        f"{arguments.out}: {report.rows} rows at {arguments.rate_hz:g} Hz; "
        f"{report.input_absent} inputs and {report.output_absent} outputs are missing"
    ]


def _mapping(words: list[str]) -> dict[str, str]:
    mapping = {}
    for word in words:
        name, sign, column = word.partition("=")
        if not sign or not column or name not in ("input", "output"):
            raise UserError(f"--map {word!r}: use --map input=COLUMN and --map output=COLUMN")
        mapping[name] = column
    return mapping
