"""Light that flickers."""

import numpy as np

from tests.fixtures.sinusoid_scene import SinusoidScene
from tests.fixtures.tracked_scenes import rms, tracked, vibration


def test_flicker_does_not_bias():
    gain = 1.0 + 0.08 * np.sin(0.7 * np.arange(40))
    assert rms(tracked(vibration(), SinusoidScene(2), gain=gain)[0][:, :2]) < 0.01
