"""What happens in a run, on a schedule: strikes at the tip, moves of the joint, when damping may act.

The controller reads the moves and the damping windows of a scenario as its external reference; the simulated
rig reads the strikes and the random disturbance. Times are on the controller's clock, from its first cycle.
"""

from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from stillarm.common.files.typed_toml import load_toml
from stillarm.common.user_error import UserError

Time = Annotated[float, Meta(ge=0.0)]


class Strike(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """An impact at the tip: mode number `mode` (1 = first) rings on from it with amplitude `deflection_m`
    (signed).

    It jumps the modal velocity by w * deflection_m.
    """

    time_s: Time
    deflection_m: Annotated[float, Meta(ge=-1e3, le=1e3)]
    mode: Annotated[int, Meta(ge=1)] = 1


class Move(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A move of the joint at constant velocity with ramps of `ramp_s` at both ends, inside [start_s, end_s]."""

    start_s: Time
    end_s: Time
    velocity_rad_s: Annotated[float, Meta(ge=-1e3, le=1e3)]
    ramp_s: Annotated[float, Meta(ge=0.0)] = 0.05


class Window(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """From `on_s` to `off_s` the joint may damp."""

    on_s: Time
    off_s: Time


class Scenario(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A whole run. `random_disturbance_m_s2` is the spectral level of a white modal acceleration, per 1 kHz
    sample.
    """

    duration_s: Annotated[float, Meta(gt=0.0)] = 30.0
    strikes: list[Strike] = []
    moves: list[Move] = []
    damping: list[Window] = []
    random_disturbance_m_s2: Annotated[float, Meta(ge=0.0, le=1e3)] = 0.0

    def reference_rad_s(self, time_s: float) -> float:
        """External joint velocity reference at a time, rad/s: the sum of the moves under way."""
        total = 0.0
        for move in self.moves:
            if move.start_s <= time_s < move.end_s:
                edge = min(time_s - move.start_s, move.end_s - time_s)
                total += move.velocity_rad_s * (min(1.0, edge / move.ramp_s) if move.ramp_s > 0.0 else 1.0)
        return total

    def damping_allowed(self, time_s: float) -> bool:
        """Whether the joint may damp at a time."""
        return any(window.on_s <= time_s < window.off_s for window in self.damping)


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Read a scenario by file, or by the name of one that comes with the program (configs/scenario_NAME.toml)."""
    path = Path(name_or_path)
    if path.suffix != ".toml":
        known = Path(__file__).parents[2] / "configs"
        path = known / f"scenario_{name_or_path}.toml"
        if not path.exists():
            names = sorted(p.stem.removeprefix("scenario_") for p in known.glob("scenario_*.toml"))
            raise UserError(
                f"scenario {name_or_path!r}: unknown; "
                f"name one of {', '.join(names)}, or a file ending in .toml"
            )
    scenario = load_toml(path, Scenario)
    spans = [(f"moves[{i}]", move.start_s, move.end_s) for i, move in enumerate(scenario.moves)]
    spans += [(f"damping[{i}]", window.on_s, window.off_s) for i, window in enumerate(scenario.damping)]
    for key, start, end in spans:
        if not start < end:
            raise UserError(f"{path}: {key}: ends at {end} s, not after its start at {start} s")
    return scenario
