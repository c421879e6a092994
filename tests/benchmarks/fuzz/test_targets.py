"""Every decoder of foreign data, on noise and on damaged true data: it reads, or raises an error of one line."""

import io
from collections.abc import Callable
from functools import cache

import msgpack
import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stillarm.benchmarks.fuzz.targets import TARGETS
from stillarm.common.datagrams.datagram import DEMO_KEY, encode
from stillarm.common.datagrams.visual_sample import VisualSample, visual_message
from stillarm.common.files.configuration import default_configuration_path
from stillarm.common.recording.header import RecordingHeader
from stillarm.common.recording.topics import FastSample, FrameSample
from stillarm.common.recording.writer import RecordingWriter

CONFIGS = default_configuration_path().parent


def _recording() -> bytes:
    file = io.BytesIO()
    header = RecordingHeader(
        program_version="0", configuration="", configuration_name="", model="", method="m", kind="live"
    )
    writer = RecordingWriter(file, header)
    for i in range(200):
        writer.write("/fast", FastSample(i * 0.01, i, i / 7))
        writer.write("/frames", FrameSample(i * 0.01, i, i, i * 0.01, i * 0.01, i, 0))
    writer.close()
    return file.getvalue()


@cache
def whole(target: str) -> bytes:
    """Something true for a decoder to read."""
    texts: dict[str, Callable[[], bytes]] = {
        "datagram": lambda: encode(DEMO_KEY, 5, 6, visual_message(7, VisualSample(1, 2, 0)))[:-16],
        "exchanges": lambda: msgpack.packb(
            msgspec.structs.astuple(visual_message(11, VisualSample(1, 2, 0, 0.5)))
        ),
        "configuration": (CONFIGS / "simulated_rig.toml").read_bytes,
        "model": (CONFIGS / "model.toml").read_bytes,
        "scenario": lambda: next(CONFIGS.glob("scenario_*.toml")).read_bytes(),
        "fast_csv": lambda: b"time_s,acceleration_m_s2\n" + b"".join(b"%d.5,0.25\n" % i for i in range(20)),
        "mapped_csv": lambda: b"a,b\n1,2\n3,4\n5,6\n",
        "recording": _recording,
        "odrive": lambda: b"0.5 0.25 *17\r\n",
        "witmotion": lambda: bytes.fromhex("5551000800100020000c6a") * 3,
        "xsens": lambda: bytes.fromhex("fa ff 36 0f 40 20 0c 3f800000 3f800000 3f800000 aa".replace(" ", "")),
    }
    return texts.get(target, lambda: b"\xfa\x01\x00\x01" + bytes(40))()


@pytest.mark.parametrize("target", TARGETS)
def test_the_true_data_are_read(target: str) -> None:
    TARGETS[target](whole(target))


@pytest.mark.parametrize("target", TARGETS)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.binary(max_size=400))
def test_noise(target: str, data: bytes) -> None:
    TARGETS[target](data)


@pytest.mark.parametrize("target", TARGETS)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_damaged(target: str, data: st.DataObject) -> None:
    """Bytes changed, put in, left out, and the end cut off."""
    damaged = bytearray(whole(target))
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, max(0, len(damaged) - 1)))
        what = data.draw(st.sampled_from(["change", "insert", "remove", "cut", "double"]))
        if what == "change" and damaged:
            damaged[at] = data.draw(st.integers(0, 255))
        elif what == "insert":
            damaged[at:at] = data.draw(st.binary(max_size=9))
        elif what == "remove":
            del damaged[at : at + data.draw(st.integers(1, 40))]
        elif what == "cut":
            del damaged[at:]
        else:
            damaged[at:at] = damaged[at : at + 60]
    TARGETS[target](bytes(damaged))


@settings(max_examples=150, deadline=None)
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers(-(2**63), 2**63) | st.floats() | st.text(max_size=9),
        lambda inner: st.lists(inner, max_size=18) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
        max_leaves=30,
    )
)
def test_signed_bodies_of_any_values(body: object) -> None:
    TARGETS["exchanges"](msgpack.packb(body))


@settings(max_examples=60, deadline=None)
@given(
    st.dictionaries(
        st.sampled_from(["link", "controller", "camera", "rig", "telemetry", "x"]), st.text(max_size=20)
    )
)
def test_configurations_of_wrong_kinds(tree: dict[str, str]) -> None:
    text = "\n".join(f"{key} = {value!r}" for key, value in tree.items())
    TARGETS["configuration"](text.encode("utf-8", "replace"))
