"""A client of Foxglove's protocol gets the telemetry as JSON, with a schema, and only what it subscribes to."""

import asyncio
import json
import shutil
import ssl
import struct
import subprocess
import time
from math import nan
from pathlib import Path

import aiohttp
import pytest

from stillarm.common.files.configuration import Telemetry
from stillarm.common.recorder.telemetry import TelemetryBatches
from stillarm.common.recording.topics import EstimateSample, FastSample
from stillarm.common.user_error import UserError
from stillarm.panel.live.foxglove_bridge import SENT, FoxgloveBridge, PemFiles, finite, schema_of

PROTOCOL = "foxglove.sdk.v1"
_MESSAGE = struct.Struct("<BIQ")  # opcode 1, subscription, log time in ns


def datagram() -> bytes:
    batches = TelemetryBatches(Telemetry())
    batches.take("/fast", FastSample(1.499, 1499, acceleration_m_s2=nan))
    batches.take("/estimate", EstimateSample(1.5, 1500, 0.07, 0.001, "", 0.01, 0.0, 0.01, 0.1, "active"))
    batches.take("/fast", FastSample(1.5, 1500, acceleration_m_s2=2.5, damping_allowed=True))
    (made,) = batches.due(0.0)
    return made


@pytest.mark.slow
def test_a_client_gets_what_it_subscribes_to_and_nothing_else() -> None:
    pytest.importorskip("foxglove", reason="no foxglove-sdk: `pip install 'stillarm[foxglove]'`")
    bridge = FoxgloveBridge("127.0.0.1", 0)

    async def run() -> list[tuple[int, dict[str, object]]]:
        url = f"ws://127.0.0.1:{bridge.port}"
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(url, protocols=(PROTOCOL,)) as client,
        ):
            channels: dict[str, dict[str, object]] = {}
            async with asyncio.timeout(5.0):
                while len(channels) < len(SENT):
                    message = await client.receive_json()
                    for one in message.get("channels", []):
                        channels[one["topic"]] = one
                assert json.loads(str(channels["/fast"]["schema"]))["type"] == "object"
                bridge.take(datagram(), 0)  # nobody subscribes yet: nothing is sent
                wanted = {"id": 7, "channelId": channels["/fast"]["id"]}
                await client.send_json({"op": "subscribe", "subscriptions": [wanted]})
                found: list[tuple[int, dict[str, object]]] = []
                arrived_ns = time.time_ns()
                while len(found) < 2:
                    if not found:
                        bridge.take(datagram(), arrived_ns)
                    try:
                        message = await client.receive(0.2)
                    except TimeoutError:
                        continue
                    if message.type is aiohttp.WSMsgType.BINARY:
                        opcode, subscription, log_ns = _MESSAGE.unpack_from(message.data)
                        assert (opcode, subscription) == (1, 7)
                        found.append((arrived_ns - log_ns, json.loads(message.data[_MESSAGE.size :])))
            return found

    try:
        before, last = asyncio.run(run())
    finally:
        bridge.close()
    assert before[0] == 1_000_000 and before[1]["acceleration_m_s2"] is None
    assert last[0] == 0 and last[1]["acceleration_m_s2"] == 2.5 and last[1]["time_s"] == 1.5


@pytest.mark.slow
def test_with_a_certificate_nothing_travels_readable(tmp_path: Path) -> None:
    """The certificate is the only one that the client trusts, and a client without TLS is refused."""
    pytest.importorskip("foxglove", reason="no foxglove-sdk: `pip install 'stillarm[foxglove]'`")
    if shutil.which("openssl") is None:
        pytest.skip("no openssl, which makes the certificate")
    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    words = ["req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1", "-subj", "/CN=localhost"]
    words += ["-addext", "subjectAltName=IP:127.0.0.1", "-keyout", str(key), "-out", str(certificate)]
    subprocess.run(["openssl", *words], check=True, capture_output=True)
    bridge = FoxgloveBridge("127.0.0.1", 0, PemFiles(certificate.read_bytes(), key.read_bytes()))

    async def run() -> str:
        trusted = ssl.create_default_context(cafile=str(certificate))
        address = f"127.0.0.1:{bridge.port}"
        async with aiohttp.ClientSession() as session:
            with pytest.raises(aiohttp.ClientError):
                await session.ws_connect(f"ws://{address}", protocols=(PROTOCOL,))
            async with session.ws_connect(f"wss://{address}", protocols=(PROTOCOL,), ssl=trusted) as client:
                return str((await client.receive_json())["name"])

    try:
        assert asyncio.run(run()) == "stillarm"
    finally:
        bridge.close()


def test_a_key_that_is_none_is_told_with_the_remedy() -> None:
    pytest.importorskip("foxglove", reason="no foxglove-sdk: `pip install 'stillarm[foxglove]'`")
    with pytest.raises(UserError, match=r"--foxglove-port 0: .*PKCS#8"):
        FoxgloveBridge("127.0.0.1", 0, PemFiles(b"no certificate", b"no key"))


def test_schemas_name_the_numbers_and_their_types() -> None:
    fast = schema_of("fast")["properties"]
    assert fast["time_s"] == {"type": "number"} and fast["damping_allowed"] == {"type": "boolean"}
    assert fast["cycle"] == {"type": "integer"} and "delay_status" not in schema_of("estimate")["properties"]


def test_what_is_no_finite_number_is_null() -> None:
    assert finite({"a": nan, "b": 1.0, "c": "text", "d": float("inf")}) == {
        "a": None,
        "b": 1.0,
        "c": "text",
        "d": None,
    }
