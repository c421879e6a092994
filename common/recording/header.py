"""A recording's description of itself: MCAP metadata at the file's beginning, so that a cut file has it too."""

import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Literal

import msgspec

from stillarm.common.files.configuration import (
    Configuration,
    default_configuration_path,
    load_configuration,
    model_path,
)
from stillarm.common.files.typed_toml import read_toml_text
from stillarm.common.user_error import UserError

FORMAT = 1  # of messages and header; goes up when an old reader would misread a new file
METADATA_NAME = "stillarm"
NOTES_NAME = "stillarm.notes"

Kind = Literal["live", "simulated", "imported"]


class RecordingHeader(msgspec.Struct, frozen=True, kw_only=True):
    """What was run, and when.

    configuration, model: the text of the TOML files; an empty model means: none was given, every key at its
    default
    configuration_name: the configuration file, or what stands for it, as it was named
    method: the estimator whose results /estimate holds
    session: the controller's session number on the link; 0 where there was no link
    origin_monotonic_s: monotonic time at which the messages' time_s is 0; 0 in virtual time
    origin_unix_ns: Unix time of the same instant, ns: log_time = origin_unix_ns + time_s
    seed: of a simulation
    notes: further facts, by name
    """

    program_version: str
    configuration: str
    configuration_name: str
    model: str
    method: str
    kind: Kind
    session: int = 0
    origin_monotonic_s: float = 0.0
    origin_unix_ns: int = 0
    seed: int | None = None
    notes: dict[str, str] = {}


def program_version() -> str:
    """Version of the program that runs."""
    try:
        return version("stillarm")
    except PackageNotFoundError:  # run from a bare source tree
        return "unknown"


def live_header(
    configuration_path: str | Path,
    configuration: Configuration,
    session: int,
    origin_monotonic_s: float,
    *,
    seed: int | None = None,
) -> RecordingHeader:
    """Header of a run in real time whose time_s is 0 at `origin_monotonic_s` (0 where time_s is the monotonic
    clock).

    Reads the wall clock once: it fixes the offset of all log times. Raises UserError when a file cannot be
    read.
    """
    return RecordingHeader(
        program_version=program_version(),
        configuration=read_toml_text(configuration_path),
        configuration_name=Path(configuration_path).name,
        model=read_toml_text(model_path(configuration, configuration_path)),
        method=configuration.controller.method,
        kind="live",
        session=session,
        origin_monotonic_s=origin_monotonic_s,
        origin_unix_ns=time.time_ns() + round((origin_monotonic_s - time.monotonic()) * 1e9),
        seed=seed,
    )


def imported_header(model: str, notes: dict[str, str], origin_unix_ns: int = 0) -> RecordingHeader:
    """Header of measured data: configs/default.toml, and the text of the model file that came with them, or none."""
    path = default_configuration_path()
    return RecordingHeader(
        program_version=program_version(),
        configuration=read_toml_text(path),
        configuration_name="configs/default.toml",
        model=model,
        method=load_configuration(path).controller.method,
        kind="imported",
        origin_unix_ns=origin_unix_ns,
        notes=notes,
    )


def header_metadata(header: RecordingHeader) -> dict[str, str]:
    """The header's fields, without the notes, as MCAP metadata: texts as they are, numbers as JSON."""
    fields = {"format": str(FORMAT)}
    for name in header.__struct_fields__:
        value = getattr(header, name)
        if name != "notes":
            fields[name] = value if isinstance(value, str) else msgspec.json.encode(value).decode()
    return fields


def read_header(fields: dict[str, str], notes: dict[str, str], name: str) -> RecordingHeader:
    """The header out of MCAP metadata; `name` stands for the file. Raises UserError for a foreign or broken one."""
    written = fields.get("format", "")
    if written != str(FORMAT):
        raise UserError(
            f"{name}: recording format {written[:20]!r}: this program reads format {FORMAT}; "
            f"open it with the stillarm that wrote it, {fields.get('program_version', 'unknown')[:40]}"
        )
    try:
        return msgspec.convert(
            {"notes": notes}
            | {k: v for k, v in fields.items() if k in _FIELDS and (k, v) != ("seed", "null")},
            RecordingHeader,
            strict=False,  # numbers out of texts
        )
    except msgspec.ValidationError as error:
        raise UserError(
            f"{name}: its header does not fit ({error}); the file is damaged or was edited"
        ) from None


_FIELDS = frozenset(RecordingHeader.__struct_fields__) - {"notes"}


def model_was_given(header: RecordingHeader) -> bool:
    """Whether the recording holds a model file, or stands on defaults alone."""
    return bool(header.model.strip())
