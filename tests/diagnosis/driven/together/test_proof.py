"""Identification on some recordings, proof on another."""

from pathlib import Path

import pytest

from stillarm.common.recording.reader import open_recording
from stillarm.diagnosis.driven.fitting.fitting import fit
from stillarm.diagnosis.driven.recording.signals import read_driven
from stillarm.diagnosis.driven.starts.start import linear_start
from stillarm.diagnosis.driven.together.joining import joined, joined_split
from stillarm.diagnosis.driven.together.proof import proofs
from tests.fixtures.current_joint import write_recording


@pytest.mark.slow
def test_a_recording_that_the_extended_model_foretells_worse_is_told(tmp_path: Path) -> None:
    """No friction in any of three; the extended model has some in the third."""
    paths = [write_recording(tmp_path / f"{k}.mcap", seed=20 + k) for k in range(3)]
    both = joined([read_driven(open_recording(one)) for one in paths])
    start = linear_start(both, joined_split(both, (0.0, 0.0, 0.0), ()))
    rubs = fit(start.box, start.numbers | {"coulomb @2": 1.0}, (), start.states)
    found = proofs(start, rubs)
    assert [one is not None and one.worse for one in found] == [False, False, True]
    assert proofs(start, rubs, lambda: -1.0) == (None, None, None)
