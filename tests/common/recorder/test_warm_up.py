"""Blank messages that warm up the recorder."""

from pathlib import Path

import msgspec
import pytest

from stillarm.common.recorder.warm_up import blank_message, warm_up
from stillarm.common.recording.topics import TOPICS, TrueState


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
def test_every_topic_has_a_blank_message_that_survives_its_encoding(topic: object) -> None:
    """A new topic is thereby warmed up as well."""
    kind = topic.message  # type: ignore[attr-defined]
    encoded = msgspec.msgpack.encode(blank_message(kind))
    assert msgspec.msgpack.encode(msgspec.msgpack.Decoder(kind).decode(encoded)) == encoded


def test_a_blank_message_holds_zeros_where_values_are_required() -> None:
    assert blank_message(TrueState) == TrueState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, [0.0])


def test_warming_up_touches_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    warm_up()
    assert not list(tmp_path.iterdir())
