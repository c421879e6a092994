"""The decoders of external input, each as a function of bytes that must never misbehave.

tests/benchmarks/fuzz runs them with hypothesis; `python -m stillarm.benchmarks.fuzz.coverage_guided TARGET`
runs them coverage-guided.
A target raises AssertionError if its result breaks its contract. Every other exception is a finding as well.
"""

import contextlib
import tempfile
from collections.abc import Callable
from hashlib import blake2s
from math import isfinite
from pathlib import Path

import msgspec

from stillarm.common.csv_bundle.bundle_import import import_bundle
from stillarm.common.csv_bundle.mapped_data import import_mapped
from stillarm.common.datagrams.datagram import (
    DEMO_KEY,
    MAX_DATAGRAM_BYTES,
    TAG_BYTES,
    Datagram,
    decode,
    kind_of,
)
from stillarm.common.datagrams.messages import MESSAGES, DriveInput
from stillarm.common.files.configuration import Configuration
from stillarm.common.files.model import Model, check_model
from stillarm.common.files.scenario import Scenario
from stillarm.common.files.typed_toml import parse_toml
from stillarm.common.recording.reader import open_recording
from stillarm.common.user_error import UserError
from stillarm.controller.input.exchange import ControllerExchange, ReferenceExchange
from stillarm.drivers.accelerometers.serial_decoders.framing import FrameDecoder
from stillarm.drivers.accelerometers.serial_devices import SERIAL_DEVICES
from stillarm.drivers.drives.drive_gateway import DriveGateway
from stillarm.drivers.drives.odrive_lines import LineReader
from stillarm.supervisor.exchange import SupervisorExchange

_OWN, _PEER = 11, 12


def _signed(payload: bytes) -> bytes:
    return payload + blake2s(payload, key=DEMO_KEY, digest_size=TAG_BYTES).digest()


def datagram(data: bytes) -> None:
    """The bytes as they are, and the same bytes signed, as a holder of the key could send by mistake."""
    for candidate in (data, _signed(data)):
        got = decode(DEMO_KEY, candidate)
        if isinstance(got, Datagram):
            assert len(candidate) <= MAX_DATAGRAM_BYTES
            assert got.session > 0 and got.sequence > 0 and got.echo >= 0


def exchanges(data: bytes) -> None:
    """A signed body of every kind with valid echo and session, which reaches the innermost checks."""
    try:
        body = msgspec.msgpack.decode(data)
    except (msgspec.DecodeError, ValueError, TypeError, RecursionError):
        return
    fields = body if isinstance(body, list) else [body]
    controller = ControllerExchange(DEMO_KEY, _OWN)
    supervisor = SupervisorExchange(DEMO_KEY, _OWN, 2)
    reference = ReferenceExchange(DEMO_KEY, _OWN)
    gateway = DriveGateway(DEMO_KEY, _OWN)
    of_inputs = DriveGateway(DEMO_KEY, _OWN, DriveInput)
    for message in MESSAGES:
        padded = (fields + [0] * 20)[: len(message.__struct_fields__)]
        try:
            signed = _signed(msgspec.msgpack.encode((2, kind_of(message), _PEER, _OWN, 1, *padded)))
        except (ValueError, TypeError, OverflowError):
            return
        for sample in controller.take([signed], 100, 0.5):
            assert 0 <= sample.started_cycle <= 100
        supervisor.take([signed], 0.5)
        reference.take([signed], 0.5)
        gateway.receive(signed, 0.5)
        of_inputs.receive(signed, 0.5)
    value = of_inputs.input_command(0.5)
    assert value is None or isfinite(value)
    velocity, _ = reference.reference(0.5)
    assert isfinite(velocity) and isfinite(gateway.velocity_command(0.5))
    assert supervisor.latest.cycle >= -1


def _toml(structure: type[Configuration] | type[Model] | type[Scenario]) -> Callable[[bytes], None]:
    def target(data: bytes) -> None:
        try:
            read = parse_toml(data.decode("utf-8", "replace"), structure, "fuzz.toml")
            if isinstance(read, Model):
                check_model(read, "fuzz.toml")
        except UserError as error:
            _one_line(error)

    return target


def _file(name: str, read: Callable[[Path], object]) -> Callable[[bytes], None]:
    def target(data: bytes) -> None:
        with tempfile.TemporaryDirectory(prefix="stillarm-fuzz-") as folder:
            path = Path(folder) / name
            path.write_bytes(data)
            try:
                read(path)
            except UserError as error:
                _one_line(error)

    return target


def _one_line(error: UserError) -> None:
    text = str(error)
    assert text and "\n" not in text, f"not one line: {text!r}"


def _read_recording(path: Path) -> None:
    recording = open_recording(path)
    for topic in recording.counts:
        with contextlib.suppress(UserError):
            for _ in recording.messages(topic):
                pass


def _frames(name: str) -> Callable[[bytes], None]:
    framing = SERIAL_DEVICES[name].framing

    def target(data: bytes) -> None:
        whole, parts = FrameDecoder(framing), FrameDecoder(framing)
        samples = whole.feed(data)
        cut = [s for i in range(0, len(data), 7) for s in parts.feed(data[i : i + 7])]
        assert repr(samples) == repr(cut), "the result depends on the chunks"
        assert len(samples) <= whole.frames

    return target


def _odrive(data: bytes) -> None:
    whole, parts = LineReader(), LineReader()
    lines = whole.feed(data)
    cut = [line for i in range(0, len(data), 5) for line in parts.feed(data[i : i + 5])]
    assert lines == cut


TARGETS: dict[str, Callable[[bytes], None]] = {
    "datagram": datagram,
    "exchanges": exchanges,
    "configuration": _toml(Configuration),
    "model": _toml(Model),
    "scenario": _toml(Scenario),
    "fast_csv": _file("fast.csv", lambda path: import_bundle(path.parent, path.with_name("out.mcap"))),
    "mapped_csv": _file(
        "data.csv",
        lambda path: import_mapped(path, {"input": "1", "output": "2"}, 100.0, path.with_name("out.mcap")),
    ),
    "recording": _file("recording.mcap", _read_recording),
    "odrive": _odrive,
    **{name: _frames(name) for name in SERIAL_DEVICES},
}
"""Targets by name."""
