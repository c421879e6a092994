"""The web application: the guard around everything, the page's files, the socket and the routes."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Any

from aiohttp import web

from stillarm.common.files.configuration import Configuration
from stillarm.controller.estimation.methods import all_methods
from stillarm.controller.safety.adjusting import max_added_damping_ratio, offered_methods
from stillarm.panel.commission.bench import Bench
from stillarm.panel.live.beside import BESIDE_COLUMNS, FIRST_KIND
from stillarm.panel.live.beside_runner import BesideRunner
from stillarm.panel.live.feed import Feed, text
from stillarm.panel.live.packing import KINDS
from stillarm.panel.operate.actions import MEANINGS
from stillarm.panel.operate.desk import Desk
from stillarm.panel.operate.permitted import READ_ONLY
from stillarm.panel.recordings.library import Library
from stillarm.panel.routes import (
    TokenUsed,
    add_commission_routes,
    add_operate_routes,
    add_recording_routes,
    add_session_routes,
)
from stillarm.panel.server.guard import Guard
from stillarm.panel.server.page_files import add_page_files
from stillarm.panel.server.socket_handler import socket_handler

_MOST_BODY_BYTES = 4096
_TICK_S = 0.1


def make_application(
    configuration: Configuration,
    guard: Guard,
    feed: Feed,
    desk: Desk,
    library: Library,
    bench: Bench,
    token_used: TokenUsed,
    methods: BesideRunner,
) -> web.Application:
    """The application. feed: gets its datagrams from the listener, as `methods` does."""
    application = web.Application(middlewares=[guard.middleware], client_max_size=_MOST_BODY_BYTES)
    about = _about(configuration)

    def first(signed_in: bool) -> list[str]:
        hello = text("hello", about | {"signed_in": signed_in, "log": list(feed.known.lines)})
        return [hello, text("status", feed.status())]

    add_page_files(application)
    application.router.add_get("/api/live", socket_handler(guard, feed.pages, first))
    add_session_routes(application, guard, token_used)
    add_operate_routes(application, guard, desk, feed)
    add_recording_routes(application, guard, library)
    add_commission_routes(application, guard, bench, feed)

    async def beside(_: web.Application) -> AsyncIterator[None]:
        desk.start(feed.known)
        ticking = asyncio.create_task(_tick(feed, methods))
        yield
        ticking.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await ticking
        await methods.close()
        await desk.close()
        await library.close()
        await bench.stop()

    application.cleanup_ctx.append(beside)
    return application


async def _tick(feed: Feed, methods: BesideRunner) -> None:
    while True:
        feed.tell_status()
        await methods.look()
        await asyncio.sleep(_TICK_S)


def _about(configuration: Configuration) -> dict[str, Any]:
    """What does not change while the panel runs."""
    controller = configuration.controller
    return {
        "kinds": [{"topic": topic, "columns": names} for topic, names in KINDS],
        "meanings": {
            action: {"label": meaning.label, "does": meaning.does, "asks": meaning.asks}
            for action, meaning in MEANINGS.items()
        },
        "read_only": READ_ONLY,
        "methods": offered_methods(controller),
        "beside": _beside(configuration),
        "max_added_damping_ratio": max_added_damping_ratio(controller),
        "max_damping_rad_s": controller.damping.max_velocity_rad_s,
        "view_rate_hz": configuration.telemetry.view_rate_hz,
    }


def _beside(configuration: Configuration) -> dict[str, Any]:
    """The methods that can be drawn beside the one in force, and why they cannot."""
    thinned = configuration.telemetry.every_cycles > 1
    why = "telemetry.every_cycles is above 1: methods need every cycle" if thinned else ""
    return {"methods": all_methods(), "columns": BESIDE_COLUMNS, "first_kind": FIRST_KIND, "why": why}
