"""Every frequency changes by its share from the onset on."""

from math import pi

import numpy as np
import pytest

from stillarm.common.files.model import Mode
from tests.fixtures.shaken_arm import CYCLE_S, arm, rings
from tests.reference.effects_judge import ringing


@pytest.mark.parametrize("share", [None, 0.0, 1.4])
def test_a_payload_changes_every_frequency_by_its_share_from_its_onset_on(share: float | None) -> None:
    """All modes change alike by default."""
    effect = {"cause": "payload_change", "onset_s": 1.5, "frequency_ratio": 0.9}
    effect |= {} if share is None else {"higher_modes_share": share}
    hz = 16.0 * (1.0 - 0.1 * (1.0 if share is None else share))
    times, found = rings(arm(effect), 0.006, 4000)
    wanted = ringing(0.006, times, frequency_hz=lambda t: 2.6 if t < 1.5 else 2.34, breaks_s=(1.5,))
    assert np.max(np.abs(found - wanted)) < 1e-8
    modes = [Mode(frequency_hz=2.6), Mode(frequency_hz=16.0, damping_ratio=0.0, participation=-0.14)]
    plant = arm(effect, modes=modes)
    for _ in range(2000):
        plant.advance(0.0)
    plant.strike(2, 0.001)
    second = []
    for _ in range(500):
        plant.advance(0.0)
        second.append(plant.modal_deflections_m[1])
    t = np.arange(1, 501) * CYCLE_S
    assert np.max(np.abs(second - 0.001 * np.sin(2.0 * pi * hz * t))) < 1e-9
