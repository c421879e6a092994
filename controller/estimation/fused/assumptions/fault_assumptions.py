"""Assumptions about wrong images, dates and filters: when these are found, and what is believed then."""

from dataclasses import dataclass

from stillarm.controller.estimation.fused.assumptions.origin import TRIED, assumed


@dataclass(frozen=True, slots=True)
class OutlierAssumptions:
    """An image outside the gate of all filters (unexplained_image.py, jumps.py)."""

    outlier_nis: float = assumed(16.0, "innovation squared", "derived: four standard deviations")
    outlier_nis_all: float = assumed(
        9.0, "innovation squared, of all filters that count", "derived: three deviations"
    )
    counts: float = assumed(0.05, "probability of a filter that counts", TRIED)
    afterwards_nis: float = assumed(4.0, "innovation squared, at most, of an image that was explained", TRIED)
    suspicious: float = assumed(
        7.0, "2 log likelihood ratio of an impact", "derived: 2.6 standard deviations"
    )
    evident: float = assumed(20.0, "2 log likelihood ratio of an impact", "derived: 4.5 standard deviations")
    votes: int = assumed(3, "images and their arrivals", TRIED)
    vote_frames: float = assumed(0.6, "frames for each frame of another count", "chosen: more than half")
    clock_known: float = assumed(5.0, "times less than a frame", TRIED)
    clock_possible: float = assumed(0.05, "probability", TRIED)
    before_frames: int = assumed(8, "frames", "bound: so many come before an impact is noticed")
    break_memory_frames: float = assumed(60.0, "frames", TRIED)
    impacts: float = assumed(1.5, "breaks within that memory", TRIED)
    size: float = assumed(
        1.5, "of an innovation", "chosen: the image may show less of the impact than its size"
    )
    higher_mode: float = assumed(0.3, "of the first mode's", TRIED)
    loose_frequency: float = assumed(
        0.04, "of the frequency", "chosen: a payload of about a tenth of the moving mass"
    )
    loose_decay: float = assumed(0.01, "of the frequency", TRIED)
    loose_scale: float = assumed(0.1, "relative", "chosen: another scene's depth")


@dataclass(frozen=True, slots=True)
class ConsistencyAssumptions:
    """Innovations and dates that cannot be (consistency.py)."""

    memory_frames: float = assumed(30.0, "frames", TRIED)
    largest_nis: float = assumed(30.0, "innovation squared", "chosen: one image may not decide alone")
    doubtful: float = assumed(2.4, "mean innovation squared", "derived: by chance once in some days")
    settled: float = assumed(1.6, "mean innovation squared", "chosen: between them it stays as it was")
    most_skew: float = assumed(
        400e-6, "relative", "bound: of a clock whose period was found right, or a stamp's"
    )
    skew_stds: float = assumed(4.0, "standard deviations", "derived: by chance once in 16,000")
    lost: float = assumed(
        4.0, "mean innovation squared", "chosen: stated deviations half of the errors are raised"
    )
    lost_after_s: float = assumed(1.0, "s", TRIED)
    patience_s: float = assumed(3.0, "s after a beginning", TRIED)
    known_patience_s: float = assumed(4.0, "s, while what was known may explain the images", TRIED)
    most_beginnings: int = assumed(3, "beginnings", "chosen: a sensor that contradicts each has another gain")
    doubt_of_lost: float = assumed(0.5, "of the amplitude", TRIED)
    least_of_lost: float = assumed(0.01, "of the first variance", TRIED)


@dataclass(frozen=True, slots=True)
class DateWatchAssumptions:
    """Dates that the accelerometer refutes (date_watch.py)."""

    memory_blocks: float = assumed(36.0, "blocks", "derived: one and a half periods")
    fewest_blocks: float = assumed(
        12.0, "blocks", "derived: half a period tells phase from amplitude and offset"
    )
    least_ratio: float = assumed(0.7, "of the amplitude", TRIED)
    largest_ratio: float = assumed(1.4, "of the amplitude", TRIED)
    phase_stds: float = assumed(6.0, "standard deviations of the phase", TRIED)
    least_rad: float = assumed(0.08, "rad", "chosen: the filters follow less by themselves")
    largest_rad: float = assumed(2.9, "rad", "chosen: nearer to pi, the sensor's sign is wrong")
    suspect_blocks: int = assumed(4, "blocks", TRIED)
    lasting_blocks: int = assumed(18, "blocks", "derived: three quarters of a period")
    singular: float = assumed(1e-3, "relative determinant", "derived: less than a quarter of a period seen")
    offset_stds: float = assumed(4.0, "standard deviations", "derived: by chance once in 16,000")


@dataclass(frozen=True, slots=True)
class FreshStartAssumptions:
    """A vibration started anew from images (fresh_start.py, fresh_fit.py, remembered.py)."""

    held_images: int = assumed(128, "images", "bound: two seconds at 65 frames a second")
    fewest_images: int = assumed(8, "images", TRIED)
    joint_held_s: float = assumed(0.95, "s", "bound: JointInput holds a second")
    ridge: float = assumed(1e-6, "of an image's information", "bound: a short window has no inverse")
    largest_nis: float = assumed(30.0, "innovation squared", "chosen: one image may not decide alone")
    recent_images: float = assumed(6.0, "images", TRIED)
    inconsistent: float = assumed(5.0, "mean innovation squared", "derived: by chance once in a day")
    astray_periods: float = assumed(5.0, "periods", "chosen: what went wrong may show for so long")
    periods: tuple[float, ...] = assumed((0.6, 1.2), "periods of images in a fit", TRIED)
    forced_periods: float = assumed(1.0, "periods", "derived: less does not tell a force from a vibration")
    again_periods: float = assumed(0.5, "periods", TRIED)
    good_misfit: float = assumed(1.5, "mean squared residual", TRIED)
    misfit_stds: float = assumed(3.0, "standard deviations of the misfit", "derived: by chance once in 700")
    good_share: float = assumed(0.05, "of the amplitude, its deviation", TRIED)
    cheaper: float = assumed(12.0, "2 log likelihood ratio, parameters paid", TRIED)
    cheaper_shaken: float = assumed(25.0, "2 log likelihood ratio under a random force", TRIED)
    no_dearer: float = assumed(
        -6.0, "2 log likelihood ratio", "chosen: nothing has changed is the simpler one"
    )
    each_s: float = assumed(1.0, "s", TRIED)
    proven_s: float = assumed(1.5, "s", TRIED)
    differs_stds: float = assumed(4.0, "standard deviations", "derived: by chance once in 16,000")
    zero_learnt: float = assumed(0.1, "of an image's variance", TRIED)
    no_random_force: float = assumed(1.2, "mean squared residual", "chosen: such a force would leave more")
    dates_doubt_frames: float = assumed(0.5, "frames", TRIED)
    clock_doubt_frames: float = assumed(0.15, "frames, of a clock that was known before", TRIED)
