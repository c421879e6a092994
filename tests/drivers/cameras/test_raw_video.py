"""Raw high-speed video, bit by bit."""

import numpy as np
import pytest

from tests.fixtures.camera_files import frames_of, write_raw


@pytest.mark.parametrize(
    ("bits", "depth", "side", "scale"),
    [
        (8, 8, "Lower", 1),
        (8, 12, "Higher", 1),
        (12, 12, "Lower", 16),
        (16, 12, "Lower", 16),
        (16, 12, "Higher", 256),
        (16, 16, "Lower", 256),
    ],
)
def test_raw_video(tmp_path, bits, depth, side, scale):
    grey = np.random.default_rng(0).integers(0, 256, (3, 34, 36))
    found = frames_of(write_raw(tmp_path, grey * scale, bits, depth, side))
    assert np.array_equal(np.stack([f.image for f in found]), grey)
    assert len(frames_of(tmp_path / "v.mraw")) == 3
