"""The page's own files, read once at the start: nothing that a request names is ever looked up on the disk."""

from collections.abc import Awaitable, Callable
from importlib.resources import files

from aiohttp import web

_TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}


def page_files() -> dict[str, tuple[bytes, str]]:
    """Content and type of each file, by its path on the server."""
    found: dict[str, tuple[bytes, str]] = {}
    for package, place in (
        ("stillarm.panel.page", "/page/"),
        ("stillarm.panel.page.vendor", "/page/vendor/"),
    ):
        for file in files(package).iterdir():
            suffix = "." + file.name.rpartition(".")[2]
            if file.is_file() and suffix in _TYPES:
                found[place + file.name] = (file.read_bytes(), _TYPES[suffix])
    found["/"] = found["/page/index.html"]
    return found


def add_page_files(application: web.Application) -> None:
    """Serve them, at exactly these paths."""
    for path, (content, content_type) in page_files().items():
        application.router.add_get(path, _file_handler(content, content_type))


def _file_handler(content: bytes, content_type: str) -> Callable[[web.Request], Awaitable[web.Response]]:
    async def handler(request: web.Request) -> web.Response:
        return web.Response(body=content, content_type=content_type, charset="utf-8")

    return handler
