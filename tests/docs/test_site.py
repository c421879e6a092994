"""The site builds strictly, without the network, and its reference pages hold everything that the code declares."""

import os
import re
import subprocess
import sys
from html import unescape
from pathlib import Path

import msgspec
import pytest

import stillarm
from stillarm.common.causes import CAUSES
from stillarm.common.files.configuration import Configuration
from stillarm.common.files.model import Model
from stillarm.common.files.scenario import Scenario
from stillarm.completion import command_of
from stillarm.main import COMMANDS, command_parser
from tests.fixtures.imports import ROOT

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built with warnings as errors: a page that nobody reaches, a link or an anchor that leads nowhere."""
    folder = tmp_path_factory.mktemp("site")
    words = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1", "http_proxy": "http://127.0.0.1:9"}
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return folder


def text_of(site: Path, page: str) -> str:
    return unescape(re.sub(r"<[^>]+>", "", (site / page / "index.html").read_text(encoding="utf-8")))


def test_every_command_and_option_is_there(site: Path) -> None:
    page = text_of(site, "reference/commands")
    for name in COMMANDS:
        options = command_of(name, "", command_parser(name)).options
        for option in [name, *(one for each in options for one in each.names)]:
            assert option in page


def keys_of(kind: type[msgspec.Struct]) -> set[str]:
    keys = set()
    for field in msgspec.structs.fields(kind):
        keys.add(field.name)
        for inside in (field.type, *getattr(field.type, "__args__", ())):
            if isinstance(inside, type) and issubclass(inside, msgspec.Struct):
                keys |= keys_of(inside)
    return keys


def test_every_key_cause_name_and_datagram_is_there(site: Path) -> None:
    page = text_of(site, "reference/configuration")
    keys = keys_of(Configuration) | keys_of(Model) | keys_of(Scenario)
    assert len(keys) > 120 and not [key for key in keys if key not in page]
    assert not [name for name in CAUSES if name not in text_of(site, "causes")]
    assert not [name for name in stillarm._FROM if name not in text_of(site, "reference/python")]
    assert "DRIVE_COMMAND" in text_of(site, "reference/datagrams")


def test_a_reader_without_the_network_misses_nothing(site: Path) -> None:
    """No font, script, style or picture of another host."""
    pages = list(site.rglob("*.html"))
    assert len(pages) > 60
    for page in pages:
        loaded = re.findall(
            r'<(?:script|img|link rel="stylesheet")[^>]+(?:src|href)="(https?:[^"]+)', page.read_text()
        )
        assert loaded == [], f"{page.relative_to(site)} loads {loaded[0]}"


def test_the_same_code_gives_the_same_pages(site: Path) -> None:
    """No address of an object in a default."""
    assert not re.search(r"0x[0-9a-f]{6,}", text_of(site, "reference/python"))
