"""The lines of ODrive's ASCII protocol, each with its checksum: N = xor of all bytes before the '*'.

Source: the firmware's communication/ascii_protocol.cpp. A line with a wrong checksum is ignored; the answer to a line
with a checksum has one as well; lines end with CR or LF.
"""

from functools import reduce
from operator import xor

_LONGEST = 256  # bytes; the firmware's own limit


def checked_line(text: str) -> bytes:
    """A command as it is sent: "u 0" becomes b"u 0 *69\\n"."""
    body = f"{text} ".encode("ascii")
    return b"%s*%d\n" % (body, reduce(xor, body))


def line_text(line: bytes) -> str | None:
    """The text of a line without its end; None if the checksum is absent or wrong, or the line is not ASCII."""
    body, star, check = line.rpartition(b"*")
    if not star or not check.isdigit() or len(check) > 3 or int(check) != reduce(xor, body, 0):
        return None
    try:
        return body.decode("ascii").strip()
    except UnicodeDecodeError:
        return None


class LineReader:
    """Splits incoming bytes into lines and keeps those with a valid checksum."""

    def __init__(self) -> None:
        """Nothing has arrived yet."""
        self._rest = b""
        self._overlong = False
        self.corrupt = 0
        """Lines without a checksum, with a wrong one, or too long."""

    def feed(self, data: bytes) -> list[str]:
        """The texts of the lines that are now complete, oldest first."""
        *lines, self._rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        texts = []
        for line in lines:
            if self._overlong:
                self._overlong = False
            elif not line:
                continue
            elif len(line) > _LONGEST or (text := line_text(line)) is None:
                self.corrupt += 1
            else:
                texts.append(text)
        if len(self._rest) > _LONGEST:
            self.corrupt += not self._overlong
            self._rest, self._overlong = b"", True
        return texts
