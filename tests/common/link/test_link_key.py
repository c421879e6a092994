"""The key that signs: from a file, readable by its owner alone."""

from pathlib import Path

import msgspec
import pytest

from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.files.configuration import Link
from stillarm.common.link.link_key import load_key
from stillarm.common.user_error import UserError


def key_file(folder: Path, content: bytes, mode: int = 0o600) -> Link:
    path = folder / "key"
    path.write_bytes(content)
    path.chmod(mode)
    return Link(key_file=str(path))


@pytest.mark.parametrize(
    ("content", "key"),
    [
        (bytes(range(128, 144)), bytes(range(128, 144))),
        (bytes(range(32)), bytes(range(32))),
        (b"00112233445566778899AABBccddeeff\n", bytes.fromhex("00112233445566778899AABBccddeeff")),
        (b"ab" * 32, b"\xab" * 32),
    ],
)
def test_key_from_a_file(tmp_path: Path, content: bytes, key: bytes) -> None:
    assert load_key(key_file(tmp_path, content)) == key


@pytest.mark.parametrize("content", [b"", b"short", bytes(33), b"xyz" * 20, b"ab" * 33, b"abc" * 11])
def test_a_file_that_holds_no_key_is_refused(tmp_path: Path, content: bytes) -> None:
    with pytest.raises(UserError, match=r"^link\.key_file = [^\n]*16 to 32 bytes[^\n]*$"):
        load_key(key_file(tmp_path, content))


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o620, 0o610])
def test_a_key_open_to_others_is_refused(tmp_path: Path, mode: int) -> None:
    with pytest.raises(UserError, match=r"^link\.key_file = [^\n]*chmod 600[^\n]*$"):
        load_key(key_file(tmp_path, bytes(32), mode))


def test_a_missing_key_is_told_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"^link\.key_file = [^\n]*no such file[^\n]*$"):
        load_key(Link(key_file=str(tmp_path / "absent")))


def test_the_demo_key_is_for_loopback_only() -> None:
    assert load_key(Link()) == DEMO_KEY
    assert load_key(Link(supervisor_host="127.3.2.1", controller_host="localhost")) == DEMO_KEY
    for host in ("0.0.0.0", "192.0.2.7", "example.org", "128.0.0.1"):
        for name in ("controller_host", "supervisor_host"):
            with pytest.raises(UserError, match=rf"^link\.key_file is empty but link\.{name} = [^\n]*$"):
                load_key(msgspec.structs.replace(Link(), **{name: host}))
