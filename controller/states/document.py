"""The two tables of docs/safety.md, out of controller.states.table."""

from controller.states.table import GROUNDS, TRANSITIONS, Event, State


def transition_table() -> str:
    """Events down, states across; a dot stays where it is."""
    lines = ["| event | " + " | ".join(State) + " |", "|---" * (len(State) + 1) + "|"]
    for event in Event:
        nexts = [TRANSITIONS[state, event] for state in State]
        words = ["." if after is state else str(after) for state, after in zip(State, nexts, strict=True)]
        lines.append(f"| {event} | " + " | ".join(words) + " |")
    return "\n".join(lines)


def ground_table() -> str:
    """What goes missing, what follows, within which times, and what the operator is told."""
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
