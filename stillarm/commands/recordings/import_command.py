"""`stillarm import`: converts measured data into a recording."""

import argparse
from pathlib import Path

from stillarm.common.user_error import UserError, reason_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "source",
        type=Path,
        metavar="SOURCE",
        help="CSV bundle (a folder); or with --look, --as or --map one file: CSV, MAT, Parquet, NumPy, MCAP, ROS 2 bag",
    )
    parser.add_argument(
        "-o",
        "--out",
        type=Path,
        metavar="FILE",
        help="recording to write (MCAP); with --look the description (TOML), its picture beside it",
    )
    parser.add_argument(
        "--look",
        action="store_true",
        help="print and draw what the file holds, and write an import description to be corrected",
    )
    parser.add_argument(
        "--as", dest="description", type=Path, metavar="DESCRIPTION", help="import as this description says"
    )
    parser.add_argument(
        "--model", type=Path, metavar="FILE", help="with --as: the rig's model file, kept in the recording"
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
    if sum((arguments.look, arguments.description is not None, bool(arguments.map))) > 1:
        raise UserError("--look, --as and --map: one of them at a time")
    if arguments.look:
        _look(arguments)
        return 0
    if arguments.out is None:
        raise UserError("-o: needed; name the recording to write (or --look at the file first)")
    if arguments.model is not None and arguments.description is None:
        raise UserError("--model: only with --as; a bundle has its own model.toml")
    from stillarm.progress import progress_bar

    with progress_bar(f"import {arguments.source.name}"):
        if arguments.description is not None:
            lines = _described(arguments)
        else:
            lines = _mapped(arguments) if arguments.map else _bundle(arguments)
    for line in lines:
        print(line)
    return 0


def _look(arguments: argparse.Namespace) -> None:
    """Print each table, write the description and the picture."""
    from stillarm.printed_rows import print_rows
    from stillarm.progress import progress_bar

    with progress_bar(f"look at {arguments.source.name}"):
        # these imports take a second: the bar comes first
        from stillarm.tables.described import described
        from stillarm.tables.drawing import draw
        from stillarm.tables.guesses.look import look
        from stillarm.tables.readers.read_file import read_table_file
        from stillarm.tables.report import column_rows, head_lines

        file = read_table_file(arguments.source)
        looks = tuple(look(table) for table in file.tables)
    for note in file.notes:
        print(f"note: {note}")
    for seen in looks:
        for line in head_lines(seen):
            print(line)
        print_rows([dict(row) for row in column_rows(seen)])
        print()
    source = arguments.source
    description = arguments.out or source.with_name(f"{source.name}.import.toml")
    if description.suffix.lower() != ".toml":
        raise UserError(f"-o {description}: with --look a description is written; name it .toml")
    try:
        description.write_text(described(file, looks).text, encoding="utf-8")
    except OSError as error:
        raise UserError(
            f"{description}: cannot be written ({reason_of(error)}); name another with -o"
        ) from None
    picture = description.with_suffix(".png")
    draw(file, looks, picture)
    print(f"{description}: correct it, then `stillarm import {source} --as {description} -o REC.mcap`")
    print(f"{picture}: the columns, drawn")


def _described(arguments: argparse.Namespace) -> list[str]:
    from stillarm.tables.description import load_description
    from stillarm.tables.importing import import_tables
    from stillarm.tables.readers.read_file import read_table_file

    description, text = load_description(arguments.description)
    file = read_table_file(arguments.source)
    report = import_tables(file, description, text, arguments.out, arguments.model)
    counts = ", ".join(f"{count} rows in {topic}" for topic, count in report.rows.items())
    lines = [f"{arguments.out}: {counts}"]
    if report.unscaled:
        lines.append(f"of unknown scale, kept as they are: {', '.join(report.unscaled)}")
    return [*lines, *report.notes]


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
