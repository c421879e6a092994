"""Assumptions about exposure times, counters, arrivals and n_i, and about the laws that date frames."""

from dataclasses import dataclass

from stillarm.controller.estimation.fused.assumptions.origin import TRIED, assumed


@dataclass(frozen=True, slots=True)
class CountAssumptions:
    """Counters and stamps of frames (dating.py)."""

    reset_back: int = assumed(8, "frames", "bound: so far back an old frame may come out of order")
    mismatch_frames: float = assumed(2.5, "frames", TRIED)
    mismatch_spreads: float = assumed(
        8.5, "spreads of the delay", "derived: six deviations of a difference of two"
    )
    mismatch_passed: float = assumed(0.02, "of the time passed", TRIED)
    stamp_mismatch_frames: float = assumed(4.0, "frames", TRIED)
    longest_stall_frames: float = assumed(
        20.0, "frames", "bound: a camera's or a socket's queue holds no more"
    )
    stall_frames: int = assumed(8, "frames", "bound: a queue that was held up has drained after so many")
    no_burst_frames: int = assumed(
        3, "frames", "chosen: if so many have not begun to catch up, there is no queue"
    )
    catches_up_frames: float = assumed(0.5, "frames", TRIED)
    recount_doubt_frames: float = assumed(
        0.7, "frames", "chosen: a count that was corrected may be off by one"
    )
    stamp_doubt_frames: float = assumed(2.0, "frames", TRIED)


@dataclass(frozen=True, slots=True)
class ArrivalAssumptions:
    """Spread and floor of arrivals, and a clock that they refute (arrivals.py, arrival_floor.py, clock_rate.py)."""

    middle_frames: int = assumed(64, "frames", "derived: a second")
    long_frames: int = assumed(256, "frames", "derived: four seconds")
    memory_frames: float = assumed(300.0, "frames", TRIED)
    long_memory_frames: float = assumed(2500.0, "frames", TRIED)
    few: int = assumed(16, "differences", "derived: the variance is known to a third then")
    enough: int = assumed(
        512, "differences over the longest time", "derived: three spans of it in all; those of one overlap"
    )
    enough_blind: int = assumed(
        64,
        "the same of n_i without an accelerometer",
        "chosen: nothing else dates an image of an arm at rest then",
    )
    doubt: float = assumed(
        5.0, "of the short difference's mean", "derived: two deviations, 2 * 1.22 * sqrt(4)"
    )
    least_walk: float = assumed(0.005, "of the white spread, in a square root second", TRIED)
    safety: float = assumed(
        1.5, "times the walk found", "chosen: its few independent differences are uncertain"
    )
    floor_frames: int = assumed(96, "frames", "derived: a second and a half")
    floor_mean_frames: float = assumed(16.0, "frames", TRIED)
    fell_spreads: float = assumed(3.0, "spreads of the delay", "chosen: less is a floor met more closely")
    above_spreads: float = assumed(
        6.0, "spreads of the delay", "chosen: such an arrival waited for something else"
    )
    rate_group: int = assumed(32, "frames, taken as their mean", "derived: half a second")
    rate_spans: tuple[int, ...] = assumed((4, 8, 16, 32, 64), "groups", "derived: 2 to 32 seconds")
    rate_beyond: float = assumed(6.0, "spreads of the delay", "derived: by chance once in thirty thousand")
    rate_even: float = assumed(
        0.5, "of an even share, in each quarter", "chosen: a delay that wanders goes in fits"
    )
    rate_most: float = assumed(0.1, "of the period", "bound: more is no clock")


@dataclass(frozen=True, slots=True)
class DateAssumptions:
    """Arrivals and n_i processed by the filters (frame_dates.py, joint_date.py)."""

    of_started: float = assumed(0.01, "of the wander between arrival and n_i", TRIED)
    strange_nis: float = assumed(36.0, "innovation squared of an n_i", "derived: six standard deviations")
    strange_frames: int = assumed(10, "frames", TRIED)
    confirmed: float = assumed(0.25, "of the variance of the clock's rate", TRIED)
    no_arrival_s2: float = assumed(1e3, "s^2", "bound: tells nothing")
    skew_walk: float = assumed(1e-14, "1/s", "chosen: 0.1 ppm in a square root second")
    waits_until: float = assumed(0.5, "of the shift's first variance", TRIED)
    joint_frames: float = assumed(200.0, "frames", TRIED)
    joint_begin_frames: int = assumed(30, "frames", TRIED)
    joint_outside_stds: float = assumed(4.0, "standard deviations", "derived: by chance once in 16,000")
    joint_least_s: float = assumed(0.0005, "s", "chosen: half a cycle, in which arrivals are read")
    joint_offset_gain: float = assumed(0.01, "of n_i's offset, a frame", TRIED)
    number_gain_least: float = assumed(0.005, "of the number's offset, a frame", TRIED)
    number_gain_most: float = assumed(0.3, "of the number's offset, a frame", TRIED)
    late_s: float = assumed(0.1, "s", "chosen: deviation of a mean delay that is not known")
    redated: float = assumed(0.3, "of what dates were found to be off by", TRIED)


@dataclass(frozen=True, slots=True)
class EvidenceAssumptions:
    """Probabilities of the laws (evidence.py)."""

    memory_frames: float = assumed(60.0, "frames", TRIED)
    refuted: float = assumed(1e-4, "probability", TRIED)
    unlikely: float = assumed(0.1, "probability", TRIED)
    possible: float = assumed(0.05, "probability", TRIED)
    usual_frames: float = assumed(300.0, "frames", TRIED)
    least_usual: float = assumed(0.01, "probability", TRIED)
    blind_handicap: float = assumed(50.0, "in the logarithm", "chosen: only a full refutation outweighs it")
    level_frames: float = assumed(300.0, "frames", TRIED)
    least_disturbed: float = assumed(0.01, "probability", TRIED)
    most_disturbed: float = assumed(0.5, "probability", "chosen: disturbed is never the rule")
    largest_nis: float = assumed(25.0, "innovation squared", "chosen: one image may not decide alone")
    lowest: float = assumed(-60.0, "in the logarithm", "chosen: far beyond a refutation")
    unproven: float = assumed(7.0, "in the logarithm, below the best", TRIED)
    least_shift_s: float = assumed(0.001, "s", "chosen: a cycle, in which arrivals are read")
    stamps_odds: float = assumed(0.7, "in the logarithm, above the clock", "chosen: stamps are mostly right")
