"""Serves the panel until it is interrupted: telemetry in, pages out. Edge: sockets, files, signals."""

import asyncio
import ipaddress
import signal
import ssl
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from aiohttp import web

from stillarm.common.files.configuration import load_configuration
from stillarm.common.user_error import UserError, reason_of
from stillarm.panel.application import make_application
from stillarm.panel.commission.bench import Bench
from stillarm.panel.live.beside_runner import BesideRunner
from stillarm.panel.live.feed import Feed
from stillarm.panel.live.foxglove_bridge import FoxgloveBridge, PemFiles
from stillarm.panel.live.listener import listen
from stillarm.panel.operate.desk import Desk
from stillarm.panel.recordings.library import Library
from stillarm.panel.server.access import Access, own_hosts
from stillarm.panel.server.guard import Guard

_CLOSE_WITHIN_S = 2.0


class Settings(NamedTuple):
    """configuration: the controller's file. recordings: the folder. host, port: where to serve; port 0: a free one.

    certificate, key: PEM files for TLS. held: whether the damping is held from the start.
    foxglove_port: where to serve Foxglove; None: nowhere.
    """

    configuration: Path
    recordings: Path
    host: str = "127.0.0.1"
    port: int = 8420
    certificate: Path | None = None
    key: Path | None = None
    held: bool = False
    foxglove_port: int | None = None


def serve(settings: Settings, say: Callable[[str], None]) -> None:
    """Serve until Ctrl-C or SIGTERM. say: takes lines for the user.

    Raises UserError for a wrong configuration, folder, certificate, or a port that is taken.
    """
    asyncio.run(_serve(settings, say))


async def _serve(settings: Settings, say: Callable[[str], None]) -> None:
    configuration = load_configuration(settings.configuration)
    if not settings.recordings.is_dir():
        raise UserError(f"--recordings {settings.recordings}: no such folder; make it, or name another")
    telemetry = configuration.telemetry
    if not telemetry.enabled:
        say("telemetry.enabled = false: nothing live will be shown; set it to true in the configuration")
    tls = _tls(settings)
    access = Access()
    desk = Desk(configuration, held=settings.held)
    feed = Feed(desk.status)
    hosts: set[str] = set()
    with tempfile.TemporaryDirectory(prefix="stillarm-panel-") as cache:
        library = Library(settings.recordings, Path(cache))
        bench = Bench(settings.configuration, settings.recordings)

        def token_used(token: str) -> None:
            say(f"the address was used; another browser can take {address}#token={token}")

        guard = Guard(access, hosts)
        beside = BesideRunner(settings.configuration, feed.pages)
        application = make_application(configuration, guard, feed, desk, library, bench, token_used, beside)
        bridge = _bridge(settings, say)

        def take(datagram: bytes) -> None:
            feed.take(datagram)
            beside.take(datagram)
            if bridge is not None:
                bridge.take(datagram, time.time_ns())

        listener = await listen(telemetry.host, telemetry.panel_port, take)
        runner = web.AppRunner(application, access_log=None, shutdown_timeout=_CLOSE_WITHIN_S)
        try:
            await runner.setup()
            port = await _open(runner, settings, tls)
            hosts |= own_hosts(settings.host, port)
            address = f"{'https' if tls else 'http'}://{_name(settings.host)}:{port}/"
            say(f"stillarm panel: {address}#token={access.token}")
            say(
                "the token works once; without it the page is read-only; Ctrl-C ends the panel, never the loop"
            )
            _warn_of_network(settings, tls, say)
            await _asked_to_end()
        finally:
            listener.close()
            if bridge is not None:
                bridge.close()
            await runner.cleanup()


async def _asked_to_end() -> None:
    """Wait for Ctrl-C or SIGTERM. A signal handler of the loop: an exception in the middle of a page's answer would
    leave others unfinished.
    """
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    await ended.wait()


async def _open(runner: web.AppRunner, settings: Settings, tls: ssl.SSLContext | None) -> int:
    """Listen; the port. Raises UserError where it is taken."""
    try:
        site = web.TCPSite(runner, settings.host, settings.port, ssl_context=tls)
        await site.start()
    except OSError as error:
        raise UserError(
            f"panel: cannot serve on {settings.host}:{settings.port} ({reason_of(error)}); "
            "choose another --port, or stop the other panel"
        ) from None
    return int(runner.addresses[0][1])


def _bridge(settings: Settings, say: Callable[[str], None]) -> FoxgloveBridge | None:
    if settings.foxglove_port is None:
        return None
    certificate, tls = settings.certificate, None
    if certificate is not None:  # _tls() has read both
        tls = PemFiles(certificate.read_bytes(), (settings.key or certificate).read_bytes())
    bridge = FoxgloveBridge(settings.host, settings.foxglove_port, tls)
    scheme = "ws" if tls is None else "wss"
    say(f"Foxglove: open connection, {scheme}://{_name(settings.host)}:{bridge.port}")
    return bridge


def _tls(settings: Settings) -> ssl.SSLContext | None:
    """TLS from the certificate's files, if there are any. Raises UserError where they cannot be used."""
    if settings.certificate is None:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(settings.certificate, settings.key)
    except (OSError, ssl.SSLError) as error:
        raise UserError(
            f"--certificate {settings.certificate}: cannot be used ({error}); give PEM files, with --key beside it"
        ) from None
    return context


def _warn_of_network(settings: Settings, tls: ssl.SSLContext | None, say: Callable[[str], None]) -> None:
    if _is_loopback(settings.host):
        return
    say(f"WARNING: {settings.host} is no loopback address: everybody on that network can watch this rig")
    if tls is None:
        say("WARNING: without --certificate and --key the token and every command travel readable for others")


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _name(host: str) -> str:
    return f"[{host}]" if ":" in host else host
