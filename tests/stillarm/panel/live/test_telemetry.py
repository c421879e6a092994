"""Telemetry as the recorder sends it comes back as rows; anything else is no telemetry, and never an error."""

import math

import msgpack
from hypothesis import given
from hypothesis import strategies as st

from stillarm.common.files.configuration import Telemetry
from stillarm.common.recorder.telemetry import TelemetryBatches
from stillarm.common.recording.topics import EstimateSample, FastSample, FrameSample
from stillarm.panel.live.telemetry import rows_of


def test_the_recorders_datagrams_are_understood() -> None:
    batches = TelemetryBatches(Telemetry())
    batches.take("/fast", FastSample(1.5, 1500, acceleration_m_s2=2.5, damping_allowed=True))
    batches.take("/estimate", EstimateSample(1.5, 1500, 0.07, math.nan, "", 0.01, 0.0, 0.01, 0.1, "active"))
    batches.take("/frames", FrameSample(1.5, 1500, 7, 1.5, 1.4, 1400, 0, 3.25))
    (datagram,) = batches.due(0.0)
    fast, estimate, frame = rows_of(datagram)
    assert fast.fast is not None and fast.fast.acceleration_m_s2 == 2.5 and fast.fast.damping_allowed
    assert estimate.estimate is not None and math.isnan(estimate.estimate.delay_std_s)
    assert frame.frames is not None and (frame.time_s, frame.frames.displacement_px) == (1.5, 3.25)


@given(st.binary(max_size=200))
def test_any_bytes_give_rows_or_none(data: bytes) -> None:
    assert isinstance(rows_of(data), list)


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(st.sampled_from(["time_s", "fast", "words", "log", "x"]), inner, max_size=3)
        ),
        max_leaves=10,
    )
)
def test_any_msgpack_gives_rows_or_none(value: object) -> None:
    assert isinstance(rows_of(msgpack.packb(value)), list)
