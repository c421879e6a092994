"""The whole application by aiohttp's client: what it serves, and the attacks that it refuses, bounded."""

import asyncio
import contextlib
import struct
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import aiohttp
import msgpack
import pytest
from aiohttp.test_utils import TestClient, TestServer

from stillarm.common.files.configuration import CameraDevice, Configuration, Link
from stillarm.panel.application import make_application
from stillarm.panel.commission.bench import Bench
from stillarm.panel.live.beside_runner import BesideRunner
from stillarm.panel.live.feed import Feed
from stillarm.panel.operate.desk import Desk
from stillarm.panel.recordings.library import Library
from stillarm.panel.server.access import Access, own_hosts
from stillarm.panel.server.guard import OWN_HEADER, Guard
from stillarm.panel.server.subscribers import MOST_PAGES, MOST_QUEUED

ROOT = Path(__file__).parents[3]
Client = TestClient  # type: ignore[type-arg]


class Panel:
    """A served application, its feed and its address."""

    def __init__(self, client: Client, feed: Feed, access: Access) -> None:
        self.client, self.feed, self.access = client, feed, access
        self.origin = f"http://127.0.0.1:{client.port}"

    def headers(self, **other: str) -> dict[str, str]:
        return {"Origin": self.origin, OWN_HEADER: "1"} | other

    async def sign_in(self) -> None:
        answer = await self.client.post(
            "/api/session", json={"token": self.access.token}, headers=self.headers()
        )
        assert answer.status == 200

    async def post(self, path: str, body: object = None, **other: str) -> tuple[int, str]:
        answer = await self.client.post(path, json=body or {}, headers=self.headers(**other))
        text: str = (await answer.json()).get("error", "")
        return answer.status, text


@asynccontextmanager
async def serving(folder: Path) -> AsyncIterator[Panel]:
    configuration = Configuration(
        camera=CameraDevice("shared_memory", "panel-test"), link=Link(reference_port=9)
    )
    access, hosts = Access(), set[str]()
    desk = Desk(configuration)
    feed = Feed(desk.status)
    recordings, cache = folder / "recordings", folder / "cache"
    recordings.mkdir()
    cache.mkdir()
    (recordings / "broken.mcap").write_bytes(b"no recording")
    (folder / "secret.mcap").write_bytes(b"x")
    application = make_application(
        configuration,
        Guard(access, hosts),
        feed,
        desk,
        Library(recordings, cache),
        Bench(ROOT / "configs" / "simulated_rig.toml", recordings),
        lambda token: None,
        BesideRunner(ROOT / "configs" / "simulated_rig.toml", feed.pages),
    )
    connector = aiohttp.TCPConnector(limit=0)
    async with TestClient(TestServer(application, host="127.0.0.1"), connector=connector) as client:
        hosts |= own_hosts("127.0.0.1", client.port or 0)
        yield Panel(client, feed, access)


def served(folder: Path, check: Callable[[Panel], Awaitable[None]]) -> None:
    async def run() -> None:
        async with serving(folder) as panel:
            await check(panel)

    asyncio.run(run())


def armed(cycle: int = 1) -> bytes:
    words = {
        **{"state": "armed", "reason": "", "damping_status": "off", "origin_monotonic_s": 0.0},
        **{"method": "fused", "added_damping_ratio": 0.12},
    }
    return msgpack.packb(
        [
            {"time_s": cycle * 1e-3, "fast": {"acceleration_m_s2": 1.0, "damping_allowed": True}},
            {"time_s": cycle * 1e-3, "words": words},
        ]
    )


def test_the_page_comes_with_a_strict_policy_and_nothing_from_outside(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        for path in ("/", "/page/panel.css", "/page/main.js", "/page/vendor/uPlot.esm.js"):
            answer = await panel.client.get(path)
            text = await answer.text()
            policy = answer.headers["Content-Security-Policy"]
            assert answer.status == 200 and "default-src 'none'" in policy and "unsafe" not in policy
            assert answer.headers["X-Content-Type-Options"] == "nosniff"
            if "vendor" not in path:
                outside = text.replace("http://www.w3.org", "").replace("xmlns", "")
                assert "http://" not in outside and "https://" not in outside
        page = await (await panel.client.get("/")).text()
        assert "<script>" not in page and "onclick=" not in page and "style=" not in page

    served(tmp_path, check)


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1:1", "", "localhost"])
def test_another_host_is_refused(tmp_path: Path, host: str) -> None:
    async def check(panel: Panel) -> None:
        answer = await panel.client.get("/", headers={"Host": host})
        assert answer.status in {400, 421} and "stillarm</h1>" not in await answer.text()

    served(tmp_path, check)


def test_another_origin_opens_no_socket_and_changes_nothing(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        await panel.sign_in()
        for origin in ("http://evil.example", "null", ""):
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                await panel.client.ws_connect("/api/live", headers={"Origin": origin})
            assert refused.value.status == 403
            assert (await panel.post("/api/operate/stop", Origin=origin))[0] == 403
        answer = await panel.client.post("/api/operate/stop", json={}, headers={"Origin": panel.origin})
        assert answer.status == 403  # a form cannot set the panel's own header
        assert len(panel.feed.pages) == 0

    served(tmp_path, check)


def test_a_wrong_token_opens_nothing_and_guessing_is_slowed(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        answers = [await panel.post("/api/session", {"token": f"guess{i}"}) for i in range(15)]
        assert [status for status, _ in answers[:10]] == [403] * 10
        assert {status for status, _ in answers[11:]} == {429}
        assert (await panel.post("/api/operate/arm", {"confirmed": True}))[0] == 403
        assert (await panel.post("/api/commission/go", {"confirmed": True}))[0] == 403

    served(tmp_path, check)


def test_the_session_is_in_a_cookie_that_no_script_reads(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        token = panel.access.token
        answer = await panel.client.post("/api/session", json={"token": token}, headers=panel.headers())
        cookie = answer.headers["Set-Cookie"]
        assert "HttpOnly" in cookie and "SameSite=Strict" in cookie and token not in cookie
        assert (await panel.post("/api/session", {"token": token}))[0] == 403

    served(tmp_path, check)


@pytest.mark.slow
def test_what_the_state_forbids_is_refused_with_its_reason(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        await panel.sign_in()
        status, why = await panel.post("/api/operate/arm", {"confirmed": True})
        assert status == 409 and "no controller is heard" in why
        panel.feed.take(armed())
        status, why = await panel.post("/api/operate/arm", {"confirmed": True})
        assert status == 409 and why == "armed already (state armed)"
        status, why = await panel.post("/api/operate/strike")
        assert status == 409 and "confirm" in why
        status, why = await panel.post("/api/operate/strike", {"confirmed": True})
        assert status == 409 and "shared memory" in why  # no rig runs
        status, why = await panel.post("/api/operate/stop")
        assert status == 409 and "no controller answers at 127.0.0.1:9" in why
        assert (await panel.post("/api/operate/explode"))[0] == 404

    served(tmp_path, check)


@pytest.mark.slow
def test_an_adjustment_outside_its_grounds_is_refused_with_the_reason(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        async def refusal(**asked: object) -> str:
            status, why = await panel.post("/api/adjust", asked)
            assert status in {400, 409}, (status, why)
            return why

        assert (await panel.post("/api/adjust", {"method": "fused", "confirmed": True}))[0] == 403
        await panel.sign_in()
        assert "confirm" in await refusal(method="timestamps")
        assert "no controller is heard" in await refusal(method="timestamps", confirmed=True)
        panel.feed.take(armed())
        assert panel.feed.status()["settings"] == {
            "method": "fused",
            "added_damping_ratio": 0.12,
            "refusals": {"gain": "", "method": ""},
        }
        assert "from 0 to 0.2" in await refusal(added_damping_ratio=0.3, confirmed=True)
        assert "one of fused, timestamps, correlation" in await refusal(method="x", confirmed=True)
        assert "nothing was asked for" in await refusal(confirmed=True)
        assert "reload" in await refusal(method="x" * 65, confirmed=True)
        panel.feed.take(armed())
        assert "no controller answers" in await refusal(added_damping_ratio=0.1, confirmed=True)

    served(tmp_path, check)


@pytest.mark.parametrize(
    "path",
    [
        *("/page/../panel.py", "/page/%2e%2e/%2e%2e/pyproject.toml", "/../../etc/passwd", "/page/vendor/"),
        *("/api/recordings/..%2fsecret.mcap", "/api/recordings/%2e%2e", "/api/recordings/.hidden.mcap"),
        *("/api/opened/..%2f..%2fx/series?topic=fast&from=0&to=1&intervals=1", "/api/opened/x/report"),
        "/api/opened/x/series?topic=..%2f..%2fsecret&from=0&to=1&intervals=1",
    ],
)
def test_no_path_leads_out_of_the_folders(tmp_path: Path, path: str) -> None:
    async def check(panel: Panel) -> None:
        from yarl import URL

        answer = await panel.client.get(URL(path, encoded=True))
        text = await answer.text()
        assert answer.status in {400, 404, 409} and "root:" not in text and "Traceback" not in text

    served(tmp_path, check)


@pytest.mark.slow
def test_a_broken_recording_is_told_in_one_line(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        listed = (await (await panel.client.get("/api/recordings")).json())["recordings"]
        assert [one["name"] for one in listed] == ["broken.mcap"]
        answer = await panel.client.get("/api/recordings/broken.mcap")
        error = (await answer.json())["error"]
        assert answer.status == 409 and "broken.mcap" in error and "\n" not in error

    served(tmp_path, check)


def test_a_large_body_and_a_large_message_are_refused(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        await panel.sign_in()
        answer = await panel.client.post("/api/operate/stop", data=b"x" * 10_000_000, headers=panel.headers())
        assert answer.status == 413
        socket = await panel.client.ws_connect("/api/live", headers={"Origin": panel.origin})
        with contextlib.suppress(ConnectionError):  # cut off while it sends
            await socket.send_bytes(b"x" * 10_000_000)
        assert await closed(socket) in {1008, 1009, 1006}
        for text in ("{", '{"ping": "x"}', '{"stop": 1}', "[]"):
            socket = await panel.client.ws_connect("/api/live", headers={"Origin": panel.origin})
            await socket.send_str(text)
            assert await closed(socket) == 1008
        await asyncio.sleep(0.05)
        assert len(panel.feed.pages) == 0

    served(tmp_path, check)


async def closed(socket: aiohttp.ClientWebSocketResponse) -> int | None:
    async with asyncio.timeout(5.0):
        while not socket.closed:
            await socket.receive()
    return socket.close_code


@pytest.mark.slow
def test_a_thousand_sockets_end_at_the_bound(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        async def one() -> aiohttp.ClientWebSocketResponse | None:
            try:
                return await panel.client.ws_connect("/api/live", headers={"Origin": panel.origin})
            except (aiohttp.WSServerHandshakeError, aiohttp.ClientError):
                return None

        sockets = [socket for _ in range(10) for socket in await asyncio.gather(*(one() for _ in range(100)))]
        opened = [socket for socket in sockets if socket is not None]
        assert len(opened) == len(panel.feed.pages) == MOST_PAGES
        panel.feed.take(armed())  # and those that are open are served
        hello = await opened[0].receive_json()
        assert hello["type"] == "hello" and hello["signed_in"] is False
        for socket in opened:
            await socket.close()

    served(tmp_path, check)


@pytest.mark.slow
def test_a_slow_reader_is_bounded_and_costs_the_others_nothing(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", panel.client.port)
        head = (
            f"GET /api/live HTTP/1.1\r\nHost: 127.0.0.1:{panel.client.port}\r\nOrigin: {panel.origin}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n"
        )
        writer.write(head.encode())
        assert b"101" in await reader.readline()
        writer.transport.pause_reading()  # type: ignore[attr-defined]
        quick = await panel.client.ws_connect("/api/live", headers={"Origin": panel.origin})
        large = bytes((2, 4)) + bytes(500_000)
        for _ in range(200):  # 100 MB
            panel.feed.pages.put(large)
            await asyncio.sleep(0)
            while True:
                message = await quick.receive()
                if message.data == large:
                    break
        slow = max(panel.feed.pages._all, key=lambda page: page.dropped)
        assert slow.dropped > 100 and slow._bytes <= 5_000_000 and len(slow._messages) <= MOST_QUEUED
        writer.close()

    served(tmp_path, check)


def test_a_page_gets_the_curves_the_words_and_the_time(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        await panel.sign_in()
        socket = await panel.client.ws_connect("/api/live", headers={"Origin": panel.origin})
        hello = await socket.receive_json()
        assert hello["signed_in"] is True and hello["kinds"][0]["topic"] == "fast"
        assert (await socket.receive_json())["silent"] is True
        panel.feed.take(armed(cycle=1500))
        message = await socket.receive()
        kind, _, rows = struct.unpack_from("<BBH", message.data)
        assert (kind, rows) == (0, 1) and struct.unpack_from("<d", message.data, 8) == (1.5,)
        status = await socket.receive_json()
        assert status["words"]["state"] == "armed" and status["actions"]["disarm"] == ""
        await socket.send_str('{"ping": 12.5}')
        while (pong := await socket.receive_json())["type"] != "pong":
            pass
        assert pong["ping"] == 12.5 and pong["server_s"] > 0.0

    served(tmp_path, check)


def test_the_steps_of_commissioning_say_what_moves(tmp_path: Path) -> None:
    async def check(panel: Panel) -> None:
        told = await (await panel.client.get("/api/commission")).json()
        assert told["steps"][0]["moves"] == "Nothing moves." and "0.06 rad" in told["steps"][2]["moves"]
        await panel.sign_in()
        assert (await panel.post("/api/commission/go"))[0] == 409
        panel.feed.take(armed())
        status, why = await panel.post("/api/commission/go", {"confirmed": True})
        assert status == 409 and "a controller is running" in why

    served(tmp_path, check)
