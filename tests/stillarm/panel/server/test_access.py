"""Token, session, Host and Origin: what is let in, and what an attacker would try."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stillarm.panel.server.access import Access, own_hosts, own_origin

HOSTS = own_hosts("127.0.0.1", 8420)


def test_a_token_opens_one_session_and_is_used_up() -> None:
    access = Access()
    token = access.token
    session = access.open_session(token)
    assert session is not None and access.holds(session)
    assert access.open_session(token) is None
    assert access.token != token and access.open_session(access.token) is not None
    assert access.holds(session)  # the other browser does not sign this one out


@given(st.text())
def test_nothing_else_opens_or_is_a_session(text: str) -> None:
    access = Access()
    access.open_session(access.token)
    assert access.open_session(text) is None
    assert not access.holds(text)


def test_the_oldest_of_many_sessions_is_signed_out() -> None:
    access = Access()
    sessions = [access.open_session(access.token) or "" for _ in range(40)]
    assert [access.holds(one) for one in sessions] == [False] * 8 + [True] * 32


def test_secrets_are_long_and_never_repeat() -> None:
    tokens = {Access().token for _ in range(100)}
    assert len(tokens) == 100 and min(map(len, tokens)) >= 43


@pytest.mark.parametrize("origin", ["http://127.0.0.1:8420", "https://localhost:8420", "http://[::1]:8420"])
def test_the_panels_own_origins(origin: str) -> None:
    assert own_origin(origin, HOSTS)


@pytest.mark.parametrize(
    "origin",
    [
        *("", "null", "http://evil.example", "http://127.0.0.1", "http://127.0.0.1:8421", "http://[::1"),
        *("http://127.0.0.1:8420.evil.example", "http://evil@127.0.0.1:8420", "file://127.0.0.1:8420"),
    ],
)
def test_foreign_origins(origin: str) -> None:
    assert not own_origin(origin, HOSTS)


def test_the_address_listened_on_is_its_own_host_and_all_addresses_are_not() -> None:
    assert "192.168.1.5:80" in own_hosts("192.168.1.5", 80)
    assert "[fe80::1]:80" in own_hosts("fe80::1", 80)
    assert not any("0.0.0.0" in host for host in own_hosts("0.0.0.0", 80))
