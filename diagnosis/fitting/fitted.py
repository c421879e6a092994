"""What a fit works on, and what it is: samples that train or are held out; quantities, noise levels, residuals."""

from dataclasses import dataclass, field

import msgspec
import numpy as np
from numpy.typing import NDArray

from stillarm.common.files.model import Model
from stillarm.diagnosis.data.channels import FRAME_CHANNELS
from stillarm.diagnosis.data.noise import LEAST, MATTERS_OF_MOTION, Colour, InstantUncertainty
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.physics.world import Predicted, World

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Colours = dict[str, Colour | InstantUncertainty]

THIN = {"joint_position": 8, "joint_velocity": 8}
"""Samples of a channel that are averaged to one: at 1 kHz 8 ms, within which a joint shows nothing new."""
_SHOWING_MODES = ("acceleration", "deflection", "displacement")  # the best first
_SET_OFF_S = 0.3  # within which a mode of 40 Hz and 1 % damping rings down to a twentieth


_SAME_S = 0.15  # between an impact and the same one moved


@dataclass(frozen=True)
class FittedChannel:
    """One measured channel of a fit, all per sample: measured and predicted in the channel's unit; residual: whitened,
    NaN where unmeasured; sigma: its noise level; colour: of its noise, None where it is white.
    """

    measured: Array
    predicted: Array
    residual: Array
    sigma: float
    colour: Colour | InstantUncertainty | None

    @property
    def off(self) -> Array:
        """Measured less predicted, not whitened."""
        return self.measured - self.predicted


@dataclass
class Fit:
    """A fitted world. free: names that were fitted; std: their standard deviations; sigma: noise level of each channel.

    held_out_score: log-likelihood of each held-out block; train_log_likelihood: of all the rest; train_blocks: of each
    block's part of the rest; residuals: per channel, whitened, not divided by sigma; NaN where unmeasured. covariance:
    of the free quantities, in their order.
    """

    world: World
    vector: Array
    free: tuple[str, ...]
    std: dict[str, float]
    sigma: dict[str, float]
    colour: Colours
    residuals: dict[str, Array]
    predicted: Predicted
    train_log_likelihood: float
    held_out_score: Array
    train_blocks: Array = field(default_factory=lambda: np.empty(0))
    covariance: Array = field(default_factory=lambda: np.empty((0, 0)))

    def value(self, name: str) -> float:
        """A quantity's value."""
        return float(self.vector[self.world.space.place[name]])

    def channel(self, name: str) -> FittedChannel | None:
        """A channel by its name; None where the recording does not hold it. No recording need hold any one channel:
        whoever asks for one by name asks here, and says what holds without it."""
        measured = self.world.channels.get(name)
        if measured is None:
            return None
        return FittedChannel(
            measured,
            self.predicted.channels[name],
            self.residuals[name],
            self.sigma[name],
            self.colour.get(name),
        )


def gain_of_each_block(after: Fit, before: Fit) -> Array:
    """Log-likelihood gained in each block, held out or not: what shows at one instant may show in any. (blocks,)"""
    return after.held_out_score - before.held_out_score + after.train_blocks - before.train_blocks


@dataclass(frozen=True)
class Data:
    """A world's channels as one problem: which samples train, which are held out, and in which block."""

    world: World
    split: Split
    train: dict[str, Mask]
    held: dict[str, Mask]
    blocks: dict[str, NDArray[np.int64]]

    def trained(self, name: str) -> Mask:
        """Which samples of a channel train; none where it was not measured."""
        return self.train.get(name, np.zeros(0, bool))

    def blocks_of(self, name: str) -> NDArray[np.int64]:
        """Block of each sample of a channel; none where it was not measured."""
        return self.blocks.get(name, np.zeros(0, np.int64))


def make_data(world: World, split: Split) -> Data:
    """Mark the samples. What an impact sets off in the higher modes is over within a part of a block: in one that is
    held out no sample would tell its size. So the accelerometer trains just after each impact, if the split lends that;
    where there is none, what else shows the arm.
    """
    train, held, blocks = {}, {}, {}
    lent = next((name for name in _SHOWING_MODES if name in world.channels), None) if split.lends else None
    for name, values in world.channels.items():
        block = split.blocks_of(world.times_of(name))
        known = np.isfinite(values)
        is_held = split.held[block]
        if name == lent:
            is_held = is_held & ~_just_struck(world, name)
        held[name] = known & is_held
        train[name] = known & ~is_held
        blocks[name] = block
    return Data(world, split, train, held, blocks)


def _just_struck(world: World, channel: str) -> Mask:
    """The samples within a while of an impact, or of the end of what held the arm, (samples,)."""
    times = world.times_of(channel)
    late_s = world.model.timing.capture_delay_s if channel in FRAME_CHANNELS else 0.0
    struck = np.zeros(len(times), bool)
    for cycle in (*world.impacts, *world.unjudged_ends):
        since = times - cycle * world.measured.cycle_s
        struck |= (since >= 0.0) & (since < _SET_OFF_S + late_s)
    return struck


def thinned(name: str, values: Array) -> Array:
    """A channel's samples, those of the joint as means of eight: nothing they show changes within milliseconds."""
    step = THIN.get(name, 1)
    if step == 1:
        return values
    count = len(values) // step
    means: Array = np.ascontiguousarray(values[: count * step]).reshape(count, step) @ np.full(
        step, 1.0 / step
    )
    return means


def thinned_mask(name: str, mask: Mask) -> Mask:
    """Which of the thinned samples are wholly within a mask."""
    step = THIN.get(name, 1)
    if step == 1:
        return mask
    count = len(mask) // step
    whole: Mask = np.asarray(mask[: count * step].reshape(count, step).all(axis=1))
    return whole


def least_level(world: World, name: str) -> float:
    """Below this a channel's noise level is never taken to be: what the simulation itself may be off."""
    if name == "deflection":
        return 1e-6 * world.variation(name)
    if name == "joint_position":  # an encoder may be finer: as much as matters to anybody (contract.md)
        least = min(LEAST[name], MATTERS_OF_MOTION * world.variation(name) or LEAST[name])
        # at rest a counter may be off by half a step for as long
        return max(least, 0.5 * world.resolution(name))
    return LEAST[name]


def refitted_model(model: Model, final: Fit) -> Model:
    """The model with the baseline's parameters as fitted; noise levels too."""
    if final.world.measured.pair:
        return model
    replace = msgspec.structs.replace
    acceleration, images = final.channel("acceleration"), final.channel("displacement")
    modes = [
        replace(
            mode,
            frequency_hz=final.value(f"modes.{i}.frequency_hz"),
            damping_ratio=final.value(f"modes.{i}.damping_ratio"),
            participation=final.value(f"modes.{i}.participation"),
        )
        for i, mode in enumerate(model.arm.modes)
    ]
    sensor, camera, timing = model.accelerometer, model.camera, model.timing
    if acceleration is not None:
        sensor = replace(
            sensor,
            bias_m_s2=final.value("accelerometer.bias_m_s2"),
            noise_std_m_s2=acceleration.sigma,
        )
    if images is not None:
        camera = replace(
            camera,
            scale_px_per_m=final.value("camera.scale_px_per_m"),
            noise_std_px=images.sigma if final.world.frame_clock.counted else camera.noise_std_px,
        )
        timing = replace(timing, capture_delay_s=max(0.0, final.value("timing.capture_delay_s")))
    return replace(
        model, arm=replace(model.arm, modes=modes), accelerometer=sensor, camera=camera, timing=timing
    )


def carried_over(last: Fit, world: World) -> Array:
    """The values of a fit in another world's vector, as far as it has them; each impact's are those of the nearest."""
    start = world.space.vector()
    old = last.world
    cycle_of_old = (0, *old.impacts)
    cycle_of_new = (0, *world.impacts)
    for name, place in world.space.place.items():
        source = name
        if name.startswith("jump."):
            _, j, mode, part = name.split(".")
            cycle = cycle_of_new[int(j)]
            off, nearest = min((abs(other - cycle), k) for k, other in enumerate(cycle_of_old))
            if int(j) == 0:
                nearest = 0
            elif nearest == 0 or off * old.measured.cycle_s > _SAME_S:
                continue
            source = f"jump.{nearest}.{mode}.{part}"
        if source in old.space.place:
            start[place] = last.value(source)
    return start
