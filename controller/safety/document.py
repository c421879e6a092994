"""Makes the three tables of docs/safety.md from stillarm.controller.safety.table."""

from stillarm.controller.safety.table import GROUNDS, MAY_ADJUST, TRANSITIONS, Event, Setting, State


def transition_table() -> str:
    """Rows are events, columns are states; a dot means no change."""
    lines = ["| event | " + " | ".join(State) + " |", "|---" * (len(State) + 1) + "|"]
    for event in Event:
        nexts = [TRANSITIONS[state, event] for state in State]
        words = ["." if after is state else str(after) for state, after in zip(State, nexts, strict=True)]
        lines.append(f"| {event} | " + " | ".join(words) + " |")
    return "\n".join(lines)


def adjusting_table() -> str:
    """Rows are settings, columns are states; a dot means that it is refused."""
    lines = ["| setting | " + " | ".join(State) + " |", "|---" * (len(State) + 1) + "|"]
    for setting in Setting:
        words = ["yes" if (setting, state) in MAY_ADJUST else "." for state in State]
        lines.append(f"| {setting} | " + " | ".join(words) + " |")
    return "\n".join(lines)


def ground_table() -> str:
    """Missing parts, reactions, times, and messages to the operator."""
    lines = [
        "| missing | concerns | reaction | counts within, s | zero within, s more | message | remedy |",
        "|---|---|---|---|---|---|---|",
    ]
    for ground in GROUNDS:
        concerns = "the whole command" if ground.whole else "the damping part"
        zero = "never" if ground.zero_within_s == 0.0 else f"{ground.zero_within_s:g}"
        lines.append(
            f"| {ground.event} | {concerns} | {ground.reaction} | {ground.seen_within_s:g} | {zero} "
            f"| {ground.message} | {ground.remedy} |"
        )
    return "\n".join(lines)
