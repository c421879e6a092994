"""The key that signs the datagrams, from the file that the configuration names."""

import os
import stat
from ipaddress import AddressValueError, IPv4Address
from pathlib import Path

from stillarm.common.datagrams.datagram import DEMO_KEY
from stillarm.common.files.configuration import Link
from stillarm.common.user_error import UserError, reason_of

NEW_KEY = "make one with `(umask 077; head -c 32 /dev/urandom > KEY_FILE)` and copy it to both computers"


def load_key(link: Link) -> bytes:
    """The key, 16 to 32 bytes. An empty link.key_file gives the demo key, on loopback hosts only.

    The file holds 16 to 32 raw bytes, or 32 to 64 hexadecimal digits; 32 bytes that are all such digits are
    taken for digits. Raises UserError for a file that cannot be read, is open to others, or holds anything
    else.
    """
    if not link.key_file:
        return _demo_key(link)
    path = Path(link.key_file).expanduser()
    place = f"link.key_file = {link.key_file!r}"
    try:
        with path.open("rb") as file:
            mode = stat.S_IMODE(os.fstat(file.fileno()).st_mode)
            content = file.read(4096)
    except OSError as error:
        raise UserError(f"{place}: cannot be read ({reason_of(error)}); {NEW_KEY}") from None
    if mode & 0o077:
        raise UserError(
            f"{place}: others may read it (mode {mode:03o}, 600 is allowed); run `chmod 600 {path}`"
        )
    key = _parse(content)
    if key is None:
        raise UserError(
            f"{place}: {len(content)} bytes that are no key; 16 to 32 bytes or 32 to 64 "
            f"hexadecimal digits are allowed; {NEW_KEY}"
        )
    return key


def is_loopback(host: str) -> bool:
    """Whether a host is this computer itself: 127.0.0.0/8, or localhost."""
    if host == "localhost":
        return True
    try:
        return IPv4Address(host).is_loopback
    except AddressValueError:
        return False


def _demo_key(link: Link) -> bytes:
    for name, host in (("controller_host", link.controller_host), ("supervisor_host", link.supervisor_host)):
        if not is_loopback(host):
            raise UserError(
                f"link.key_file is empty but link.{name} = {host!r} lies outside this computer, "
                f"where the demo key (127.0.0.0/8 only) protects nothing; name a key file: {NEW_KEY}"
            )
    return DEMO_KEY


def _parse(content: bytes) -> bytes | None:
    digits = content.strip()
    if (
        32 <= len(digits) <= 64
        and len(digits) % 2 == 0
        and all(d in b"0123456789abcdefABCDEF" for d in digits)
    ):
        return bytes.fromhex(digits.decode("ascii"))
    return content if 16 <= len(content) <= 32 else None
