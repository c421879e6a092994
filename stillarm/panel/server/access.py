"""Access control: the one-time token, the sessions that it opens, and the panel's own Host and Origin. Pure.

A token is exchanged once for a session, whose number the browser keeps in a cookie that no script can read. Both are
compared in constant time.
"""

import hashlib
import secrets
from collections.abc import Callable
from collections.abc import Set as AbstractSet
from hmac import compare_digest
from urllib.parse import urlsplit

_MOST_SESSIONS = 32  # browsers that are signed in; the oldest is signed out by the next one
_LOOPBACK_NAMES = ("127.0.0.1", "localhost", "[::1]")


def new_secret() -> str:
    """256 random bits, as text that fits an address and a cookie."""
    return secrets.token_urlsafe(32)


def _digest(text: str) -> bytes:
    """Digest of one length, so that the time of a comparison tells nothing of the secret's length."""
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).digest()


class Access:
    """The present token and the open sessions."""

    def __init__(self, draw: Callable[[], str] = new_secret) -> None:
        """draw: where secrets come from."""
        self._draw = draw
        self._sessions: list[bytes] = []
        self.token = draw()
        """Opens one session; another takes its place then."""

    def open_session(self, token: str) -> str | None:
        """The new session's secret for the right token, which is used up by that; None for a wrong one."""
        if not compare_digest(_digest(token), _digest(self.token)):
            return None
        self.token = self._draw()
        session = self._draw()
        self._sessions = [*self._sessions, _digest(session)][-_MOST_SESSIONS:]
        return session

    def holds(self, session: str) -> bool:
        """Whether a cookie's value is an open session."""
        given = _digest(session)
        found = False
        for one in self._sessions:  # all of them, so that the time does not tell which one
            found |= compare_digest(given, one)
        return found


def own_hosts(bind: str, port: int, names: tuple[str, ...] = ()) -> frozenset[str]:
    """The values of the Host header that name this server; any other may come from a rebound DNS name.

    bind: the address listened on. names: further names by which the user reaches it.
    """
    hosts = {*_LOOPBACK_NAMES, *names}
    if bind not in {"0.0.0.0", "::"}:
        hosts.add(f"[{bind}]" if ":" in bind else bind)
    return frozenset(f"{host.lower()}:{port}" for host in hosts)


def own_origin(origin: str, hosts: AbstractSet[str]) -> bool:
    """Whether a browser says that the request comes from the panel's own page."""
    try:
        parts = urlsplit(origin)
    except ValueError:
        return False
    return parts.scheme in {"http", "https"} and parts.netloc.lower() in hosts
