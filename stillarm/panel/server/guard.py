"""Checks each request before it is answered (Host, Origin, rate, session), and sets the headers of each answer.

Refused: another Host (DNS rebinding), another Origin on a request that changes something or opens a socket (CSRF), too
many requests of one address, a command without a session.
"""

import time
from collections.abc import Callable
from collections.abc import Set as AbstractSet

from aiohttp import web
from aiohttp.typedefs import Handler, Middleware

from stillarm.panel.server.access import Access, own_origin
from stillarm.panel.server.rate import RateLimit

COOKIE = "stillarm_panel"
OWN_HEADER = "X-Stillarm-Panel"  # a form or an image on another site cannot set it
CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_HEADERS = {
    "Content-Security-Policy": CONTENT_POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_PER_S, _BURST = 200.0, 1000  # twenty pages that load at once
_SIGN_IN_PER_S, _SIGN_IN_BURST = 0.5, 10


class Guard:
    """Judges requests. `middleware` goes into the application."""

    def __init__(
        self, access: Access, hosts: AbstractSet[str], clock: Callable[[], float] = time.monotonic
    ) -> None:
        """hosts: from own_hosts(), which may be filled later: the port is known late. clock: s, for the rate limits."""
        self.access = access
        self._hosts = hosts
        self._clock = clock
        self._requests = RateLimit(_PER_S, _BURST)
        self._sign_ins = RateLimit(_SIGN_IN_PER_S, _SIGN_IN_BURST)

    def signed_in(self, request: web.Request) -> bool:
        """Whether the request carries an open session."""
        return self.access.holds(request.cookies.get(COOKIE, ""))

    @property
    def middleware(self) -> Middleware:
        """The function that aiohttp calls around each handler."""

        @web.middleware
        async def guarded(request: web.Request, handler: Handler) -> web.StreamResponse:
            refusal = self._refusal(request)
            try:
                answer = refusal or await handler(request)
            except web.HTTPException as error:
                answer = error_response(error.status, error.text or error.reason)
            if not answer.prepared:
                for name, value in _HEADERS.items():
                    answer.headers.setdefault(name, value)
            return answer

        return guarded

    def _refusal(self, request: web.Request) -> web.Response | None:
        if request.headers.get("Host", "").lower() not in self._hosts:
            return error_response(421, "this address is not the panel's own; open the one that it printed")
        writes = request.method not in {"GET", "HEAD"}
        opens = request.headers.get("Upgrade", "").lower() == "websocket"
        if (writes or opens) and not own_origin(request.headers.get("Origin", ""), self._hosts):
            return error_response(403, "this request does not come from the panel's own page")
        if writes and request.headers.get(OWN_HEADER) != "1":
            return error_response(
                403, f"the header {OWN_HEADER} is missing; only the panel's own page sends it"
            )
        return self._too_often(request, writes)

    def _too_often(self, request: web.Request, writes: bool) -> web.Response | None:
        if writes and self.signed_in(request) and request.path.endswith("/stop"):
            return None  # an emergency stop waits for nothing
        address, now_s = request.remote or "", self._clock()
        allowed = self._requests.allows(address, now_s)
        if allowed and request.path == SIGN_IN_PATH:
            allowed = self._sign_ins.allows(address, now_s)
        return None if allowed else error_response(429, "too many requests; wait a few seconds")

    def require_session(self, request: web.Request) -> None:
        """Raise HTTPForbidden for a page that may only look."""
        if not self.signed_in(request):
            raise web.HTTPForbidden(text="read-only: open the address with the token that the panel printed")


SIGN_IN_PATH = "/api/session"


def error_response(status: int, text: str) -> web.Response:
    """A refusal that a page can show: {"error": ...}."""
    return web.json_response({"error": text}, status=status)
