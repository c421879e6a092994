"""Assumptions about the accelerometer, the impacts that it shows, and the joint's encoder."""

from dataclasses import dataclass

from stillarm.controller.estimation.fused.assumptions.origin import TRIED, assumed


@dataclass(frozen=True, slots=True)
class BlockAssumptions:
    """Accelerometer blocks."""

    first_periods: float = assumed(
        1 / 24, "periods of the first mode", "derived: the mean then holds all but 0.5 %"
    )
    highest_periods: float = assumed(
        1 / 8, "periods of the highest mode", "derived: the mean loses 2.6 % of its amplitude"
    )
    fewest_cycles: int = assumed(3, "cycles", "chosen: a block's scatter needs a few samples")
    most_cycles: int = assumed(25, "cycles", TRIED)
    backlog_s: float = assumed(0.15, "s beyond the model's delay", "chosen: so late may an image come")
    grown: float = assumed(2.5, "times the sensor's variance", TRIED)
    motion_doubt: float = assumed(
        0.01,
        "of what the joint's motion adds to a phasor",
        "chosen: participation and drive are known to some per cent",
    )
    step_doubt: float = assumed(
        0.2,
        "of a step of force",
        "chosen: a step takes time, and the phase at its beginning is not quite known",
    )
    along: float = assumed(
        1.5, "of a guessed impact, in the direction of a rate", "chosen: its size is rough"
    )
    across: float = assumed(0.3, "of a guessed impact, at right angles to it", "chosen: so is its instant")


@dataclass(frozen=True, slots=True)
class SampleAssumptions:
    """Samples, and the sensor's health by itself."""

    least_noise_m_s2: float = assumed(0.005, "m/s^2", "chosen: a learnt noise never falls below it")
    stuck_cycles: int = assumed(30, "cycles", TRIED)
    clipped: float = assumed(0.98, "of the range", "chosen: a little below the range")
    likely_cut: float = assumed(
        2.0, "standard deviations from a limit", "derived: 2 % of samples beyond it are cut"
    )
    huber: float = assumed(
        4.0, "standard deviations", "derived: exceeded once in 16,000 samples of white noise"
    )
    scatter: float = assumed(12.0, "standard deviations", TRIED)
    noise_cycles: float = assumed(700.0, "cycles", TRIED)
    noisy: float = assumed(4.0, "times the stated variance", "chosen: twice the stated noise is worth a word")
    spiking: float = assumed(0.01, "share of samples beyond the bound", TRIED)
    spikes_cycles: float = assumed(1000.0, "cycles", TRIED)
    allowance: float = assumed(0.2, "of the first mode's amplitude, by frequency ratio squared", TRIED)
    clip_hits: int = assumed(6, "of the same extreme value", TRIED)
    clip_times_next: int = assumed(
        4, "times the next value's", "chosen: noise has fewer on its outermost value"
    )
    clip_watched_cycles: int = assumed(1000, "cycles", TRIED)


@dataclass(frozen=True, slots=True)
class AgainstImagesAssumptions:
    """What images make of the accelerometer: gain, offset, strain."""

    memory_blocks: float = assumed(25.0, "blocks", "derived: about a period")
    largest_nis: float = assumed(40.0, "innovation squared", "chosen: one block may not decide alone")
    few_blocks: float = assumed(8.0, "blocks", "derived: a third of a period")
    gain_off: float = assumed(0.3, "of the gain", TRIED)
    gain_right: float = assumed(0.2, "of the gain", TRIED)
    gain_known: float = assumed(0.1, "standard deviation of the gain", TRIED)
    gain_stds: float = assumed(3.5, "standard deviations", "derived: by chance once in two thousand")
    sees_gain_std: float = assumed(0.15, "standard deviation of the gain over a period", TRIED)
    drifted_stds: float = assumed(
        5.0, "standard deviations of the offset", "derived: by chance once in 1.7 million"
    )
    drift_kept: float = assumed(0.985, "of a drift, in each block after it", TRIED)
    drift_goes_on: float = assumed(0.1, "of a drift's variance, a block", TRIED)
    drift_told: float = assumed(0.994, "of what is told of a drift, a block", TRIED)
    strained: float = assumed(2.5, "mean normalised difference squared", TRIED)
    tense: float = assumed(
        1.5, "mean normalised difference squared", "derived: by chance in one block of forty"
    )
    alarms_s: float = assumed(1.0, "s", TRIED)
    most_alarms: float = assumed(4.0, "alarms within that time", "bound: no arm is struck so often")


@dataclass(frozen=True, slots=True)
class ImpactDetectorAssumptions:
    """Impacts by the likelihood ratio of the blocks' residuals."""

    blocks: int = assumed(12, "blocks", "derived: half a period")
    significant: float = assumed(
        28.0, "2 log likelihood ratio", "derived: 5.3^2, by chance once in some hours"
    )
    more_per_mode: float = assumed(
        3.0, "2 log likelihood ratio, for each mode more", "derived: one more free size"
    )
    usual_stds: float = assumed(10.0, "of a block's noise: a usual impact, at least", TRIED)
    again_s: float = assumed(0.6, "s in which another would not be told from the one before", TRIED)


@dataclass(frozen=True, slots=True)
class ImpactMeterAssumptions:
    """Impacts measured sample by sample."""

    drift_stds: float = assumed(1.0, "standard deviations", "paper: Page 1954, half of the shift to be found")
    alarm_stds: float = assumed(12.0, "standard deviations", "derived: by chance once in a thousand hours")
    most_of_one_stds: float = assumed(
        6.0, "standard deviations", "chosen: one or two wild samples are no impact"
    )
    over_stds: float = assumed(2.0, "standard deviations", "chosen: the impact is still under way")
    quiet_cycles: int = assumed(6, "cycles before and after", TRIED)
    longest_rad: float = assumed(0.35, "rad of the mode's phase", "derived: over it a cosine falls to 0.94")
    quiet_stds: float = assumed(
        3.0, "standard deviations of a mean", "derived: by chance once in four hundred"
    )
    mean_stds: float = assumed(3.0, "standard deviations", "derived: by chance once in four hundred")
    quiet_share: float = assumed(0.25, "of an impact's mean", TRIED)
    edge_cycles: float = assumed(
        0.4, "of a sample's peak", "derived: a pulse begins and ends between samples"
    )
    instant_cycles: float = assumed(0.29, "cycles", "derived: 1 / sqrt(12), uniform within a cycle")
    step_stds: float = assumed(
        4.0, "standard deviations of a sample", "chosen: smaller steps are left to images"
    )
    steady_share: float = assumed(
        0.6, "of a step's mean, by its thirds", "chosen: below the 0.94 of a cosine"
    )


@dataclass(frozen=True, slots=True)
class JointAssumptions:
    """The joint's encoder, and a joint at rest."""

    held_cycles: int = assumed(1024, "cycles", "bound: a second, beyond any capture delay")
    slope_s: float = assumed(0.002, "s; the rate is taken over twice this", TRIED)
    noise_cycles: float = assumed(500.0, "cycles", TRIED)
    between_samples: float = assumed(
        2 / 3, "of a sample's variance", "derived: mean over linear interpolation"
    )
    lately_s: float = assumed(0.5, "s", "bound: images of so long ago may still come")
    third_difference: float = assumed(20.0, "of white noise's variance", "derived: 1 + 9 + 9 + 1")
    short_cycles: int = assumed(16, "cycles", TRIED)
    rest_cycles: int = assumed(64, "cycles", TRIED)
    moved_stds: float = assumed(5.0, "standard deviations", "derived: by chance once in a day")
    slow_share: float = assumed(
        0.002, "of a resting joint's drift, a cycle", "bound: thermal drift and creep"
    )
    least_rad: float = assumed(1e-9, "rad", "bound: rounding")
