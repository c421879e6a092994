"""Requirements under every fault: limits, no motion without grounds, and recovery afterwards.

The judge reads the commands that the drive's side follows, at its instants. It uses nothing of the controller.
"""

from dataclasses import dataclass, field
from math import isfinite

GRACE_S = 0.2
"""Time from the loss of a command's grounds until it must be zero."""
_ZERO_RAD_S = 1e-12


@dataclass(frozen=True)
class Trace:
    """Commands that the drive followed, rad/s, and their times from the fault's beginning, s."""

    times_s: list[float]
    commands_rad_s: list[float]


@dataclass
class Verdict:
    """Result of one injection. reaction_s: time until the command stayed zero, if its grounds were gone; else None."""

    kind: str
    reaction_s: float | None = None
    command_max: float = 0.0
    messages_lost: int = 0
    violations: list[str] = field(default_factory=list)


def judge(
    kind: str,
    trace: Trace,
    *,
    limit_rad_s: float,
    groundless_s: tuple[float, float] | None,
    back_by_s: float | None,
    messages_lost: int = 0,
) -> Verdict:
    """Judge one injection.

    limit_rad_s: the drive's largest velocity. groundless_s: interval in which the command had no grounds; None
    if it always had. back_by_s: time by which it must be non-zero again; None if not required.
    """
    verdict = Verdict(kind, messages_lost=messages_lost)
    for time_s, command in zip(trace.times_s, trace.commands_rad_s, strict=True):
        if not isfinite(command) or abs(command) > limit_rad_s * (1.0 + 1e-9):
            verdict.violations.append(f"command of {command} rad/s at {time_s:.3f} s: beyond the limits")
            break
    verdict.command_max = max((abs(c) for c in trace.commands_rad_s if isfinite(c)), default=0.0)
    if groundless_s is not None:
        verdict.reaction_s = _judge_stillness(verdict, trace, *groundless_s)
    if back_by_s is not None and not any(
        abs(c) > _ZERO_RAD_S
        for t, c in zip(trace.times_s, trace.commands_rad_s, strict=True)
        if (groundless_s[1] if groundless_s else 0.0) < t <= back_by_s
    ):
        verdict.violations.append(f"not back {back_by_s:.1f} s after the fault began")
    return verdict


def _judge_stillness(verdict: Verdict, trace: Trace, from_s: float, to_s: float) -> float:
    moving = [
        t
        for t, c in zip(trace.times_s, trace.commands_rad_s, strict=True)
        if from_s <= t < to_s and abs(c) > _ZERO_RAD_S
    ]
    last = max(moving, default=from_s)
    if last > from_s + GRACE_S:
        verdict.violations.append(
            f"still commanded {last - from_s:.3f} s after the loss of its grounds; {GRACE_S:g} s is allowed"
        )
    return last - from_s


def table(verdicts: list[Verdict]) -> dict[str, object]:
    """The result of a campaign, with one row for each kind, in order of appearance."""
    kinds = list(dict.fromkeys(v.kind for v in verdicts))
    rows = []
    for kind in kinds:
        of_kind = [v for v in verdicts if v.kind == kind]
        reactions = [v.reaction_s for v in of_kind if v.reaction_s is not None]
        rows.append(
            {
                "kind": kind,
                "times": len(of_kind),
                "reaction_s_max": max(reactions) if reactions else None,
                "command_max": max(v.command_max for v in of_kind),
                "messages_lost": sum(v.messages_lost for v in of_kind),
                "violations": sum(len(v.violations) for v in of_kind),
            }
        )
    return {
        "injections": len(verdicts),
        "kinds": len(kinds),
        "violations": sum(len(v.violations) for v in verdicts),
        "rows": rows,
        "violation_texts": [f"{v.kind}: {text}" for v in verdicts for text in v.violations][:50],
    }
