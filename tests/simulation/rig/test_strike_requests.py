"""A strike that is asked for: it falls once, beside the scenario's, and a rig that does not run says so."""

import os
from pathlib import Path

import msgspec
import numpy as np
import pytest

from stillarm.common.files.configuration import CameraDevice, Configuration
from stillarm.common.files.model import load_model
from stillarm.common.files.scenario import Scenario, Strike
from stillarm.common.user_error import UserError
from stillarm.simulation.arm.ahead import ready_plant
from stillarm.simulation.arm.disturbance import Disturbance
from stillarm.simulation.rig.strike_requests import StrikesOnRequest, request_strike, strikes_name

ROOT = Path(__file__).parents[3]


def test_a_request_strikes_once_beside_the_scenario() -> None:
    configuration = Configuration(camera=CameraDevice("shared_memory", f"test-{os.getpid()}"))
    plant = ready_plant(load_model(ROOT / "configs" / "model.toml"))
    scenario = Scenario(strikes=[Strike(0.002, 0.003)])
    disturbance = Disturbance(scenario, 1, 0.001, np.random.default_rng(0))
    strikes = StrikesOnRequest(disturbance, strikes_name(configuration))
    try:
        assert strikes.act_on(plant, 0.0) == []
        request_strike(configuration)
        (asked,) = strikes.act_on(plant, 0.001)
        assert abs(asked.deflection_m) == 0.00625 and asked.mode == 1
        assert strikes.act_on(plant, 0.002) == scenario.strikes
        request_strike(configuration)
        request_strike(configuration)  # within one cycle: a single blow
        assert len(strikes.act_on(plant, 0.003)) == 1
        assert strikes.act_on(plant, 0.004) == []
    finally:
        strikes.close()
    with pytest.raises(UserError, match="strikes"):
        request_strike(msgspec.structs.replace(configuration))
