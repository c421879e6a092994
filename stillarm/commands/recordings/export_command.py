"""`stillarm export`: writes a recording as tables."""

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("recording", type=Path, metavar="REC", help="recording (MCAP)")
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="DIR", help="folder for the tables")
    parser.add_argument(
        "--parquet", action="store_true", help="Parquet instead of CSV (needs the package pyarrow)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Export, and list the files."""
    from stillarm.common.csv_bundle.bundle_export import export_csv, export_parquet
    from stillarm.common.recording.reader import open_recording
    from stillarm.progress import progress_bar

    with progress_bar(f"export {arguments.recording.name}"):
        recording = open_recording(arguments.recording)
        written = (export_parquet if arguments.parquet else export_csv)(recording, arguments.out)
    for path in written:
        print(path)
    return 0
