"""`stillarm panel`: a page in the browser, to see the loop and recordings and to operate the rig."""

import argparse
from pathlib import Path

from stillarm.common.user_error import UserError

_PORT = 8420


def port(text: str) -> int:
    """A port; 0 for a free one."""
    if not text.isascii() or not text.isdigit() or not 0 <= int(text) <= 65535:
        raise argparse.ArgumentTypeError(f"{text!r}: a port from 0 (a free one) to 65535")
    return int(text)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="the controller's configuration file (the program's default)",
    )
    parser.add_argument(
        "--recordings", type=Path, default=Path(), metavar="DIR", help="folder of recordings (here)"
    )
    parser.add_argument("--port", type=port, default=_PORT, metavar="P", help=f"port of the page ({_PORT})")
    parser.add_argument(
        "--host", default="127.0.0.1", metavar="H", help="address to serve on (127.0.0.1: this computer only)"
    )
    parser.add_argument(
        "--hold-damping",
        action="store_true",
        help="hold the damping from the start, until the page allows it",
    )
    parser.add_argument(
        "--foxglove-port",
        type=port,
        metavar="P",
        help="serve Foxglove's WebSocket protocol, too (8765 is usual)",
    )
    parser.add_argument("--certificate", type=Path, metavar="FILE", help="PEM certificate, for https")
    parser.add_argument("--key", type=Path, metavar="FILE", help="the certificate's private key")


def run(arguments: argparse.Namespace) -> int:
    """Serve until Ctrl-C."""
    from stillarm.common.files.configuration import default_configuration_path

    require_panel()
    from stillarm.panel.panel import Settings, serve

    settings = Settings(
        configuration=arguments.config or default_configuration_path(),
        recordings=arguments.recordings,
        host=arguments.host,
        port=arguments.port,
        certificate=arguments.certificate,
        key=arguments.key,
        held=arguments.hold_damping,
        foxglove_port=arguments.foxglove_port,
    )
    serve(settings, _say)
    return 0


def require_panel() -> None:
    """Raise UserError where aiohttp is not installed."""
    try:
        import aiohttp  # noqa: F401
    except ImportError:
        raise UserError("panel: needs aiohttp; install it with `pip install 'stillarm[panel]'`") from None


def _say(line: str) -> None:
    print(line, flush=True)
