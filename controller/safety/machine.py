"""The state machine: applies the table in each cycle, and decides whether to move, to damp, and how to stop."""

from stillarm.controller.safety.table import (
    BIT_OF,
    GROUND_OF,
    GROUNDS,
    MOVING,
    TRANSITIONS,
    Event,
    Ground,
    Operator,
    Reaction,
    State,
)

RECOVER_S = 0.2  # without a missing part for this time the system is healthy again


class StateMachine:
    """State, reason and permission. Logic only: grounds and the operator's requests are bits."""

    def __init__(self, cycle_s: float, *, arm_at_start: bool) -> None:
        """arm_at_start: whether the joint may move as soon as the checks before arming hold."""
        self._recover_cycles = max(1, round(RECOVER_S / cycle_s))
        self._arm_at_start = self._arm_when_idle = arm_at_start
        self._healthy_cycles = 0
        self.state = State.PREFLIGHT
        self.reason: Event | None = None
        """The missing ground, or the cause of the state; None while nothing is wrong."""
        self.may_move = False
        self.may_damp = False
        self.at_once = False
        """Whether the command goes to zero at once if it may not move; otherwise it fades."""

    def step(self, elapsed: int, missing: int, operator: int, *, ready: bool, damping: bool) -> None:
        """Advance by `elapsed` cycles.

        missing: grounds, as bits of BIT_OF. operator: bits of Operator. ready: whether the checks before arming pass.
        damping: whether the damping acted in the previous cycle.
        """
        if missing or operator or self._unsettled(damping):
            self._walk(elapsed, missing, operator, ready, damping)

    def _unsettled(self, damping: bool) -> bool:
        """Whether a cycle without missing grounds or requests can change the state."""
        return self.state is not (_DAMPING if damping else _ARMED)

    def _walk(self, elapsed: int, missing: int, operator: int, ready: bool, damping: bool) -> None:
        if operator & Operator.EMERGENCY_STOP:
            missing |= _EMERGENCY_STOP
        if operator & Operator.DISARM:
            self._arm_when_idle = False
            self._take(Event.DISARM)
        elif operator & Operator.CLEAR and not missing & _EMERGENCY_STOP:
            self._take(Event.CLEAR)
        self._health(elapsed, missing)
        if ready and not missing & _BEFORE_ARMING:
            self._take(Event.READY)
            if (operator & Operator.ARM and not operator & Operator.DISARM) or self._arm_when_idle:
                self._take(Event.ARM)
        self._take(Event.DAMPING_BEGUN if damping else Event.DAMPING_ENDED)
        self._permit(missing)

    def _health(self, elapsed: int, missing: int) -> None:
        if not missing:
            self._healthy_cycles += elapsed
            if self._healthy_cycles >= self._recover_cycles:
                self._take(Event.HEALTHY)
            return
        self._healthy_cycles = 0
        for ground, bit in _BITS:
            if missing & bit:
                self._take(ground.event)

    def _take(self, event: Event) -> None:
        following = TRANSITIONS[self.state, event]
        if following is self.state:
            return
        self.state = following
        if following is State.FAULT:
            self._arm_when_idle = False
            self.reason = event
        elif following is State.PREFLIGHT and event is Event.DRIVE_LOST:
            self._arm_when_idle = self._arm_at_start
            self.reason = event
        elif following is State.IDLE:
            self.reason = event if event is Event.DISARM else None
        elif following is not State.DEGRADED:
            self.reason = None

    def _permit(self, missing: int) -> None:
        """Set what the state and the present grounds allow."""
        if self.state is State.DEGRADED:
            self.reason = _heaviest(missing) or self.reason
        moving = self.state in MOVING
        self.may_move = moving and not missing & _WHOLE
        self.may_damp = self.may_move and not missing & _STOPS_DAMPING
        if not self.may_move:
            cause = GROUND_OF.get(self.reason) if self.reason is not None else None
            sudden = cause is not None and cause.reaction is Reaction.ZERO
            self.at_once = sudden or bool(missing & _STOPS_AT_ONCE)


def _heaviest(missing: int) -> Event | None:
    return next((ground.event for ground, bit in _BITS if missing & bit), None)


def _mask(*grounds: Ground) -> int:
    return sum(BIT_OF[ground.event] for ground in grounds)


_BITS = tuple((ground, BIT_OF[ground.event]) for ground in GROUNDS)
_DAMPING, _ARMED = State.DAMPING, State.ARMED
_EMERGENCY_STOP = BIT_OF[Event.EMERGENCY_STOP]
_WHOLE = _mask(*(ground for ground in GROUNDS if ground.whole))
_STOPS_DAMPING = _mask(*(ground for ground in GROUNDS if ground.reaction is not Reaction.HOLD))
_STOPS_AT_ONCE = _mask(*(ground for ground in GROUNDS if ground.whole and ground.reaction is Reaction.ZERO))
_BEFORE_ARMING = _mask(*(ground for ground in GROUNDS if ground.whole))
