"""When a force that lasts may have begun: images tell it, at once or by innovations that keep their sign.

Implements Eqs. 56, 58 of docs/fused.md.
"""

from math import sqrt

from stillarm.controller.estimation.fused.accelerometer.blocks import Jump
from stillarm.controller.estimation.fused.filters.image_update import ImageInnovation
from stillarm.controller.estimation.fused.filters.jumps import end_force, give_force, inflate, loosen
from stillarm.controller.estimation.fused.filters.laws import QUIET
from stillarm.controller.estimation.fused.fusion.state import FusionState


def begin_force(state: FusionState, time_s: float, size_m: float) -> bool:
    """Let a force begin at that time, and return whether it may: not while a steady random force shakes the arm, not
    before the image's zero is known, from which a force deflects the tip, and not where the filters have never been
    consistent and the arm vibrates. It is asked of the likeliest quiet filter: those hold the force, and the disturbed
    ones have been loosened for another explanation."""
    held = state.held_force
    if not held.may_begin(time_s):
        return False
    if not held.active:
        quiet = int(state.evidence.weights[QUIET].argmax())
        zero_variance = state.bank.zero_variance(quiet, state.held_m)
        if state.shaken or zero_variance > state.assumed.held_force.zero_known * state.image_m2:
            return False
        if not state.consistency.proven and size_m < held.by_wrong_dates_m(state.amplitude_m):
            return False
        give_force(state.bank, state.slow_pull.followed_m())
    held.begin(time_s, size_m)
    return True


def watch_slow_pull(state: FusionState, innovation: ImageInnovation, time_s: float) -> None:
    """An image within its gate, exposed at time_s: whether innovations have kept their sign for half a period."""
    best = state.evidence.best
    std = sqrt(float(innovation.variance[best]))
    bank, held_m = state.bank, state.held_m
    zero, scale = float(bank.x[best, state.at.offset]), float(bank.x[best, state.at.scale])
    whose, zero_then, scale_then = state.zero_then
    if best == whose:  # as images show it where the joint is now: its own motion is no pull
        state.zero_m += zero - zero_then + (scale - scale_then) * held_m
    state.zero_then = best, zero, scale
    variance = bank.zero_variance(best, held_m)
    pulled = state.slow_pull.see(float(innovation.residual[best]) / std, state.zero_m, variance)
    if pulled and not state.shaken:
        state.slow_pull.restart()
        size_m = state.assumed.held_force.first_stds * std
        if begin_force(state, time_s, size_m):
            none = (0.0,) * state.at.modes
            inflate(state.bank, Jump(time_s, none, none, size_m), QUIET)


def follow_force(state: FusionState) -> None:
    """After an image: end the force's state if no force is left, or if it reverses as only a changed arm would."""
    held, bank, best, f = state.held_force, state.bank, state.evidence.best, state.at.force
    if held.active and held.see(bank.edge_s, float(bank.x[best, f]), float(bank.p[best, f, f])):
        end_force(bank)
        held.end(bank.edge_s)
    elif held.active and held.oscillates(bank.edge_s):
        end_force(bank)
        held.end(bank.edge_s)
        loosen(bank)
