"""A rig with its effects as it is recorded."""

from dataclasses import dataclass

from tests.hidden_world.rigs.images import Images, displacement, images
from tests.hidden_world.rigs.motion import Motion, move
from tests.hidden_world.rigs.moves import Move
from tests.hidden_world.rigs.rig import Effect, Rig, Values
from tests.hidden_world.rigs.sensors import acceleration, encoder


@dataclass(frozen=True)
class Recording:
    """acceleration, position, speed: a value a cycle, or None where there is no such sensor; px: a value an image."""

    rig: Rig
    motion: Motion
    images: Images
    acceleration: Values | None
    position: Values | None
    speed: Values | None
    px: Values


def record(
    rig: Rig,
    moves: list[Move],
    effects: tuple[Effect, ...] = (),
    noise: bool = True,
    motion: Motion | None = None,
    nuisance: bool = True,
) -> Recording:
    """motion: of the same arm, to save the time of computing it again."""
    motion = motion or move(rig, moves, effects, nuisance)
    seen = images(rig, effects)
    felt = acceleration(rig, motion, effects, noise) if rig.accelerometer else None
    position, speed = encoder(rig, motion, noise) if rig.encoder else (None, None)
    return Recording(
        rig, motion, seen, felt, position, speed, displacement(rig, motion, seen, effects, noise)
    )
