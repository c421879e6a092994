"""mkdocs' hooks: the generated reference pages, and links that leave docs/.

A page links to code by its path in the repository, so that the links work in an editor and on the repository's page.
On the site such a link leads to the repository's page. A path that is not there fails the build.
"""

import re
from pathlib import Path
from typing import Any

import commands_page
import configuration_page
import constants_page
import python_page

from stillarm.common.datagrams.protocol_document import message_tables

ROOT = Path(__file__).resolve().parents[2]
_LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)(#[^)]*)?\)")
_TITLE = "# Datagrams\n\n[protocol.md](../protocol.md) says what surrounds these tables.\n\n"
GENERATED = {
    "reference/commands.md": commands_page.page,
    "reference/configuration.md": configuration_page.page,
    "reference/constants.md": constants_page.page,
    "reference/python.md": python_page.page,
    "reference/datagrams.md": lambda: _TITLE + message_tables(),
}


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that are made from the code."""
    from mkdocs.structure.files import File

    for path, make in GENERATED.items():
        files.append(File.generated(config, path, content=make()))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Lead links that leave docs/ to the repository. Raises mkdocs' PluginError for a path that is not there."""
    return with_repository_links(markdown, page.file.src_path, config.repo_url)


def with_repository_links(markdown: str, source: str, repository: str) -> str:
    """The page's text. source: its path in docs/."""
    folder = (ROOT / "docs" / source).parent

    def led(match: re.Match[str]) -> str:
        target, anchor = match.group(1), match.group(2) or ""
        path = (folder / target).resolve()
        if path.is_relative_to(ROOT / "docs") and path.is_file() and not _excluded(path):
            return match.group(0)
        if source in GENERATED or path in {ROOT / "docs" / page for page in GENERATED}:
            return match.group(0)
        if not path.is_relative_to(ROOT) or not path.exists():
            from mkdocs.exceptions import PluginError

            raise PluginError(f"docs/{source}: the link {target} leads nowhere")
        kind = "tree" if path.is_dir() else "blob"
        return f"]({repository}/{kind}/main/{path.relative_to(ROOT)}{anchor})"

    return _LINK.sub(led, markdown)


def _excluded(path: Path) -> bool:
    """What mkdocs.yml leaves out of the site: code beside the pages."""
    return path.suffix in (".py", ".c", ".ipynb", ".toml")
