"""The benchmark's arm: one mode behind a joint without limits, moved by the simulation's own stepper."""

from stillarm.benchmarks.estimators.world.regimes import CYCLE_S, Arm
from stillarm.common.files.model import Arm as ModelArm
from stillarm.common.files.model import Drive, Mode, Model
from stillarm.simulation.arm.plant import Plant

_UNLIMITED = 1e9


def arm_plant(
    arm: Arm, length_m: float, participation: float, bandwidth_hz: float, dead_cycles: int
) -> Plant:
    """At rest at zero; commands arrive dead_cycles late."""
    drive = Drive(
        bandwidth_hz=bandwidth_hz,
        dead_time_s=dead_cycles * CYCLE_S,
        max_velocity_rad_s=_UNLIMITED,
        max_acceleration_rad_s2=_UNLIMITED,
        min_position_rad=-_UNLIMITED,
        max_position_rad=_UNLIMITED,
    )
    mode = Mode(arm.frequency_hz, arm.damping_ratio, participation)
    return Plant(Model(arm=ModelArm(length_m=length_m, modes=[mode]), drive=drive))


def rate_m_s(plant: Plant) -> float:
    """Rate of the deflection."""
    return plant.modal_rates_m_s[0]


def amplitude_m(plant: Plant, arm: Arm) -> float:
    """Momentary amplitude of the deflection."""
    return float(abs(complex(plant.deflection_m, rate_m_s(plant) / arm.angular_frequency)))


def strike(plant: Plant, arm: Arm, velocity_m_s: float) -> None:
    """Add to the deflection's rate at once."""
    plant.strike(1, velocity_m_s / arm.angular_frequency)
