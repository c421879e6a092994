"""The requests of the page, beside its files and its socket."""

import time
from collections.abc import Awaitable, Callable
from math import nan
from typing import Annotated, Any, Protocol

import msgspec
from aiohttp import web

from stillarm.common.datagrams.messages import Adjustment
from stillarm.common.user_error import UserError
from stillarm.panel.commission.bench import Bench
from stillarm.panel.live.feed import Feed
from stillarm.panel.operate.actions import Action
from stillarm.panel.operate.desk import Desk
from stillarm.panel.recordings.library import Library
from stillarm.panel.server.guard import COOKIE, SIGN_IN_PATH, Guard, error_response

# same origin, without scripts: so the page hears the Escape key in the report's frame
_REPORT_POLICY = (
    "sandbox allow-same-origin; default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
    "frame-ancestors 'self'"
)
_SESSION_S = 12 * 3600
_MOST_INTERVALS = 30_000
Answer = Callable[[web.Request], Awaitable[web.Response]]


class _Token(msgspec.Struct, forbid_unknown_fields=True):
    token: str


class _Asked(msgspec.Struct, forbid_unknown_fields=True):
    confirmed: bool = False


class _Adjustment(msgspec.Struct, forbid_unknown_fields=True):
    """A method or a gain, or both; null: as it is."""

    method: Annotated[str, msgspec.Meta(max_length=64)] | None = None
    added_damping_ratio: float | None = None
    confirmed: bool = False


class TokenUsed(Protocol):
    """Told when a token was used, with the next one."""

    def __call__(self, token: str) -> None: ...


def told(answer: Answer) -> Answer:
    """A handler whose UserError becomes an answer that the page shows."""

    async def handler(request: web.Request) -> web.Response:
        try:
            return await answer(request)
        except UserError as error:
            return error_response(409, str(error))

    return handler


async def _body(request: web.Request, kind: type[Any]) -> Any:
    """The request's JSON. Raises HTTPBadRequest for anything else."""
    try:
        return msgspec.json.decode(await request.read(), type=kind)
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError):
        raise web.HTTPBadRequest(text="this is not what the panel's page sends; reload it") from None


def add_session_routes(application: web.Application, guard: Guard, token_used: TokenUsed) -> None:
    """Signing in by the token."""

    async def sign_in(request: web.Request) -> web.Response:
        given = await _body(request, _Token)
        session = guard.access.open_session(given.token)
        if session is None:
            return error_response(
                403, "the token is wrong or was used already; take the newest address that the panel printed"
            )
        token_used(guard.access.token)
        answer = web.json_response({"signed_in": True})
        answer.set_cookie(
            COOKIE,
            session,
            max_age=_SESSION_S,
            httponly=True,
            samesite="Strict",
            secure=request.secure,
            path="/",
        )
        return answer

    application.router.add_post(SIGN_IN_PATH, sign_in)


def add_operate_routes(application: web.Application, guard: Guard, desk: Desk, feed: Feed) -> None:
    """The operator's actions."""

    async def operate(request: web.Request) -> web.Response:
        guard.require_session(request)
        try:
            action = Action(request.match_info["action"])
        except ValueError:
            raise web.HTTPNotFound(text="there is no such action") from None
        asked = await _body(request, _Asked)
        if desk.asks(action) and not asked.confirmed:
            return error_response(409, "something would move: confirm it in the page")
        await desk.act(action, feed.known, time.monotonic())
        feed.tell_status()
        return web.json_response({"sent": action})

    async def adjust(request: web.Request) -> web.Response:
        guard.require_session(request)
        asked = await _body(request, _Adjustment)
        if not asked.confirmed:
            return error_response(409, "the damping would change: confirm it in the page")
        ratio = nan if asked.added_damping_ratio is None else asked.added_damping_ratio
        await desk.adjust(Adjustment(asked.method or "", ratio), feed.known, time.monotonic())
        feed.tell_status()
        return web.json_response({"sent": "adjustment"})

    application.router.add_post("/api/adjust", told(adjust))
    application.router.add_post("/api/operate/{action}", told(operate))


def add_recording_routes(application: web.Application, guard: Guard, library: Library) -> None:
    """Routes to the folder's recordings. Reading needs no session; requests that take computing time do."""

    async def listed(request: web.Request) -> web.Response:
        return web.json_response({"recordings": library.listed()})

    async def opened(request: web.Request) -> web.Response:
        key = await library.open(request.match_info["name"])
        return web.json_response(library.about(key))

    async def about(request: web.Request) -> web.Response:
        return web.json_response(library.about(request.match_info["key"]))

    async def series(request: web.Request) -> web.Response:
        query = request.query
        try:
            from_s, to_s = float(query["from"]), float(query["to"])
            intervals = min(int(query["intervals"]), _MOST_INTERVALS)
        except (KeyError, ValueError):
            raise web.HTTPBadRequest(text="from, to (s) and intervals are needed as numbers") from None
        content = library.series(request.match_info["key"], query.get("topic", ""), from_s, to_s, intervals)
        return web.Response(body=content, content_type="application/octet-stream")

    async def view(request: web.Request) -> web.Response:
        try:
            time_s = float(request.query["time"])
        except (KeyError, ValueError):
            raise web.HTTPBadRequest(text="time (s) is needed as a number") from None
        found = library.view(request.match_info["key"], time_s)
        spans = {"X-Time-S": repr(found.time_s), "X-Until-S": repr(found.until_s)}
        return web.Response(body=found.message, content_type="application/octet-stream", headers=spans)

    async def start(request: web.Request) -> web.Response:
        guard.require_session(request)
        await library.start(request.match_info["what"], request.match_info["key"])
        return web.json_response({"sent": request.match_info["what"]})

    async def job(request: web.Request) -> web.Response:
        return web.json_response({"job": library.job(request.match_info["what"], request.match_info["key"])})

    async def report(request: web.Request) -> web.Response:
        answer = web.Response(text=library.report(request.match_info["key"]), content_type="text/html")
        answer.headers["Content-Security-Policy"] = _REPORT_POLICY
        return answer

    routes = application.router
    routes.add_get("/api/recordings", told(listed))
    routes.add_get("/api/recordings/{name}", told(opened))
    routes.add_get("/api/opened/{key}", told(about))
    routes.add_get("/api/opened/{key}/series", told(series))
    routes.add_get("/api/opened/{key}/view", told(view))
    routes.add_get("/api/opened/{key}/report", told(report))
    routes.add_post("/api/opened/{key}/{what:replay|diagnose|images}", told(start))
    routes.add_get("/api/opened/{key}/{what:replay|diagnose|images}", told(job))


def add_commission_routes(application: web.Application, guard: Guard, bench: Bench, feed: Feed) -> None:
    """Commissioning."""

    async def state(request: web.Request) -> web.Response:
        return web.json_response(bench.told())

    async def check(request: web.Request) -> web.Response:
        guard.require_session(request)
        return web.json_response((await bench.check()).told())

    async def commission(request: web.Request) -> web.Response:
        guard.require_session(request)
        asked = await _body(request, _Asked)
        if not asked.confirmed:
            return error_response(409, "the joint would move: confirm it in the page")
        heard = not feed.known.silent(time.monotonic())
        return web.json_response((await bench.commission(controller_heard=heard)).told())

    async def stop(request: web.Request) -> web.Response:
        guard.require_session(request)
        await bench.stop()
        return web.json_response({"sent": "stop"})

    async def picture(request: web.Request) -> web.Response:
        try:
            content = bench.picture().read_bytes()
        except OSError:
            raise web.HTTPNotFound(text="there is no picture yet") from None
        return web.Response(body=content, content_type="image/png")

    routes = application.router
    routes.add_get("/api/commission", told(state))
    routes.add_get("/api/commission/picture", told(picture))
    routes.add_post("/api/commission/check", told(check))
    routes.add_post("/api/commission/go", told(commission))
    routes.add_post("/api/commission/stop", told(stop))
