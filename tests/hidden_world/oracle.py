"""How clearly an effect shows in its recording: the expected log-likelihood ratio, in nats, of the true model over the
refitted baseline; and which plain parameters describe its rough form best.

Where an effect changes a mean: half the squared norm of the whitened difference that the baseline's freedoms leave
(Wilks: the ratio's expectation under the true model), refitted to the end where they bring it far. Where it changes a
law (spikes, losses, bursts): the ratio of the laws on what was drawn. Where its course is chance (gusts): the ratio of
its law, as `chance.py` has it. Frames before their image or clock is known are judged as in `whitened.py`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import exp, log, sqrt

import numpy as np
from numpy.typing import NDArray

from tests.hidden_world.baseline import Baseline, baseline
from tests.hidden_world.chance import RANDOM, Law, burst_nats, law_of
from tests.hidden_world.clocks import bursts, frames
from tests.hidden_world.draw import departure_of, sized
from tests.hidden_world.effects import CAUSES, UNKNOWN, Effect
from tests.hidden_world.feeler import spikes
from tests.hidden_world.refit import detunes, refitted_nats
from tests.hidden_world.rig import TICK_S
from tests.hidden_world.whitened import acceleration_noise, by_channel, whitened
from tests.hidden_world.world import Case, Open, run

Array = NDArray[np.float64]

RARE_LOSS = 1e-3
"""What the baseline thinks of a lost frame: one in a thousand is nobody's fault."""
_NATS_TO_PLACE_A_BURST = 5.0
_GROWTHS = 6


@dataclass
class Oracle:
    """For one case; keeps the linearised baseline, so that many sizes of the same effect cost little."""

    case: Case
    _base: Baseline | None = None
    _laws: dict[str, Law] = field(default_factory=dict)

    def nats(self, case: Case | None = None, refits: int = 4, to_the_end: bool = False) -> float:
        """Expected nats of a case that differs from the oracle's own in its effects only.

        to_the_end: with the baseline linearised anew on the way, where an effect changes how the arm rings.
        """
        case = case or self.case
        lawful = tuple(e for e in case.effects if _is_law(e))
        random = tuple(e for e in case.effects if e.name in RANDOM)
        meaning = tuple(e for e in case.effects if not _is_law(e) and e.name not in RANDOM)
        out = sum(_law_nats(case, e) for e in lawful) + sum(self._random_nats(case, e) for e in random)
        if meaning:
            out += self._mean_nats(replace(case, effects=meaning), refits, to_the_end)
        return float(out)

    def base(self, case: Case, command: Array, impacts: int) -> Baseline:
        """The baseline's Jacobian is that of the first command seen; its value that of this one."""
        if self._base is None:
            self._base = baseline(case, command, impacts)
        elif not np.array_equal(command, self._base.command):
            bare = replace(case, effects=())
            self._base.at = whitened(bare, run(bare, Open(command=command)))
            self._base.command = command
        return self._base

    def by_channel(self, case: Case) -> dict[str, tuple[float, float]]:
        """(nats, rms over the noise's) of what is left of each channel, as the linearised baseline tells it. Laws are
        not counted."""
        clean = run(case)
        base = self.base(case, clean.command, len(clean.impact_time))
        left = base.left(whitened(case, clean) - base.at)
        out, begin = {}, 0
        for name, part in by_channel(case, clean).items():
            power = float(np.sum(left[begin : begin + len(part)] ** 2))
            out[name] = (0.5 * power, (power / len(part)) ** 0.5)
            begin += len(part)
        return out

    def _random_nats(self, case: Case, effect: Effect) -> float:
        if effect.name not in self._laws:
            usual = effect.with_value("amount", sqrt(UNKNOWN[effect.name][0] * UNKNOWN[effect.name][1]))
            self._laws[effect.name] = law_of(usual, lambda one: self._shown(replace(case, effects=(one,))))
        nats = self._laws[effect.name].nats(effect["amount"])
        if effect.name == "correlated_bursts" and "acceleration" in case.kept:
            hiss, noise = case.rig.feeler.hiss, acceleration_noise(case.rig)
            nats = max(nats, burst_nats(effect, hiss, noise, case.duration_s))
        return nats

    def _shown(self, case: Case) -> dict[str, tuple[float, Array]]:
        """Samples a second and what is left of each channel that an effect without a clock can show in."""
        clean = run(case)
        base = self.base(case, clean.command, len(clean.impact_time))
        left = base.left(whitened(case, clean) - base.at)
        out, begin = {}, 0
        for name, part in by_channel(case, clean).items():
            if name not in ("arrival", "stamp"):
                rate = case.rig.eye.rate if name == "image" else 1.0 / TICK_S
                out[name] = (rate, left[begin : begin + len(part)])
            begin += len(part)
        return out

    def _mean_nats(self, case: Case, refits: int, to_the_end: bool = False) -> float:
        clean = run(case)
        base = self.base(case, clean.command, len(clean.impact_time))
        there = whitened(case, clean)
        difference = there - base.at
        best = 0.5 * float(np.sum(base.left(difference) ** 2))
        steps = np.zeros(len(base.free))
        for _ in range(refits):
            steps = steps + base.absorbed(difference)
            difference = there - base.moved(steps)
            before, best = best, min(best, 0.5 * float(np.sum(difference**2)))
            if best > 0.98 * before:
                break
        if to_the_end and any(detunes(effect) for effect in case.effects):
            best = refitted_nats(case, there, base)
        return best


def expected_nats(case: Case) -> float:
    """Of all the case's effects together over the refitted baseline."""
    return Oracle(case).nats()


def scale_to(case: Case, nats: float, which: int = 0, oracle: Oracle | None = None) -> Case:
    """The case with its effect `which` sized so that it alone is worth about so many nats, as far as is physical."""
    oracle, effect = oracle or Oracle(case), case.effects[which]
    low, high = UNKNOWN.get(effect.name) or (CAUSES[effect.name].smallest, CAUSES[effect.name].largest)
    sign = -1.0 if departure_of(effect, case.rig) < 0.0 else 1.0

    def at(log_size: float) -> tuple[Effect, float]:
        sized_effect = sized(effect, case.rig, sign * exp(log_size))
        try:
            return sized_effect, oracle.nats(replace(case, effects=(sized_effect,)))
        except ValueError:  # it would tear the arm apart
            return sized_effect, float("inf")

    a, b = log(low), log(high)
    guess = a
    for _ in range(14):
        chosen, reached = at(guess)
        close = reached > 0.0 and abs(log(min(reached, 1e300) / nats)) < 0.1
        if close or (guess == a and reached > nats) or (guess == b and reached < nats) or b - a < 0.02:
            break
        a, b = (a, guess) if reached > nats else (guess, b)
        aimed = guess + 0.5 * log(nats / reached) if 0.0 < reached < float("inf") else 0.5 * (a + b)
        guess = aimed if a < aimed < b else 0.5 * (a + b) if b - a > 0.3 else b if reached < nats else a
    if detunes(effect):
        chosen = _enough(chosen, nats, log(high), lambda size: at(size)[0], oracle, case)
    effects = tuple(chosen if place == which else e for place, e in enumerate(case.effects))
    return replace(case, effects=effects)


def _enough(
    chosen: Effect,
    nats: float,
    highest: float,
    sized_to: Callable[[float], Effect],
    oracle: Oracle,
    case: Case,
) -> Effect:
    """Grown until the baseline refitted to the end leaves enough of it, or as far as is physical."""
    size = log(abs(departure_of(chosen, case.rig)))
    for _ in range(_GROWTHS):
        try:
            reached = oracle.nats(replace(case, effects=(chosen,)), to_the_end=True)
        except ValueError:  # it would tear the arm apart
            return chosen
        if reached > 0.8 * nats or size >= highest - 1e-9:
            return chosen
        size = min(size + min(max(0.5 * log(nats / max(reached, 1e-3)), 0.15), 1.2), highest)
        chosen = sized_to(size)
    return chosen


def best_plain(case: Case, which: int = 0, rounds: int = 4, oracle: Oracle | None = None) -> Effect:
    """The plain form's parameters that describe the rough effect best, noise apart, beside a refitted baseline."""
    return fitted_plain(case, which, rounds, oracle)[0]


def fitted_plain(
    case: Case, which: int = 0, rounds: int = 4, oracle: Oracle | None = None
) -> tuple[Effect, float]:
    """The same, and the nats that the plain form cannot describe.

    A scan of the size where it is a threshold, then Gauss-Newton on what the baseline leaves of rough minus plain.
    Laws: what was drawn, counted.
    """
    effect = case.effects[which]
    if _is_law(effect):
        return _counted(case, effect), 0.0
    names = _fitted(effect)
    if not names:
        return effect.plain, 0.0
    alone = replace(case, effects=(effect,))
    clean = run(alone)
    base = (oracle or Oracle(alone)).base(alone, clean.command, len(clean.impact_time))
    there = whitened(alone, clean)

    def left(tried: Effect) -> Array:
        made = replace(case, effects=(tried,))
        return base.left(there - whitened(made, run(made, Open(command=clean.command))))

    plain = effect.plain
    now = left(plain)
    for tried in _thresholds(effect):
        if float(np.sum((after := left(tried)) ** 2)) < float(np.sum(now**2)):
            plain, now = tried, after
    for _ in range(rounds):
        columns, units = [], []
        for name in names:
            unit = _unit(name, plain[name], departure_of(plain, case.rig))
            columns.append(left(plain.with_value(name, plain[name] + unit)) - now)
            units.append(unit)
        steps = np.linalg.lstsq(np.stack(columns, axis=1), -now, rcond=None)[0]
        gained = 0.0
        for share in (1.0, 0.3, 0.1):
            tried = plain
            for name, unit, step in zip(names, units, steps.tolist(), strict=True):
                tried = tried.with_value(name, tried[name] + share * unit * step)
            try:
                after = left(tried)
            except ValueError:
                continue
            gained = float(np.sum(now**2) - np.sum(after**2))
            if gained > 0.0:
                plain, now = tried, after
                break
        if gained < 0.01:
            break
    return plain, 0.5 * float(np.sum(now**2))


_SCANNED = {
    "drive_saturation": (0.96, 0.97, 0.98, 0.99),
    "accelerometer_clipping": (0.96, 0.97, 0.98, 0.99),
    "gear_backlash": (0.6, 0.75, 0.9, 1.1),
}


def _thresholds(effect: Effect) -> list[Effect]:
    """Other sizes to start from, where a small change of the plain form may change nothing."""
    size = CAUSES[effect.name].size
    return [effect.plain.with_value(size, part * effect[size]) for part in _SCANNED.get(effect.name, ())]


def _is_law(effect: Effect) -> bool:
    return effect.name in CAUSES and CAUSES[effect.name].law


def _fitted(effect: Effect) -> tuple[str, ...]:
    if effect.name in UNKNOWN or effect.name in ("stale_frame_buffer", "clock_step"):
        return ()
    return CAUSES[effect.name].names


def _unit(name: str, value: float, departure: float) -> float:
    """A step to differentiate by: a thousandth of what departs, except where a parameter is a place in time or band."""
    fixed = {"onset_s": 2e-3, "frequency_hz": 1e-5 * value, "damping_ratio": 1e-2 * value}
    return fixed.get(name, 1e-3 * abs(departure) if departure else 1e-3)


def _law_nats(case: Case, effect: Effect) -> float:
    """Log ratio of the law with the effect over the law without, on what the case's seed draws."""
    if effect.name == "impulse_noise":
        return _impulse_nats(case, effect) if "acceleration" in case.kept else 0.0
    if "image" not in case.kept:
        return 0.0
    drawn = frames(case.rig, (effect,), case.duration_s, case.seed)
    if effect.name == "frame_drops":
        n, m = len(drawn.lost), int(np.sum(drawn.lost))
        f = max(m, 0.5) / n
        return m * log(f / RARE_LOSS) + (n - m) * log((1.0 - f) / (1.0 - RARE_LOSS))
    norm = Oracle(case)._mean_nats(case if case.effects == (effect,) else replace(case, effects=(effect,)), 0)
    count = len(bursts(effect, float(drawn.middle[-1])))
    return max(norm - _NATS_TO_PLACE_A_BURST * count, 0.0)


def _impulse_nats(case: Case, effect: Effect) -> float:
    """Spikes in white noise against white noise of the deviation that they make it seem to have."""
    ticks = round(case.duration_s / TICK_S)
    sigma, size = case.rig.feeler.hiss, effect["amplitude_m_s2"]
    spike = spikes((effect,), ticks)
    noise = sigma * np.random.default_rng((case.seed, 100)).standard_normal(ticks)
    seen = noise + spike
    share = max(float(np.mean(spike != 0.0)), 1e-6)
    wide = float(np.hypot(sigma, 0.3 * size))

    def normal(deviation: float, centre: float = 0.0) -> Array:
        return np.asarray(np.exp(-0.5 * ((seen - centre) / deviation) ** 2) / deviation)

    mixed = (1.0 - share) * normal(sigma) + 0.5 * share * (normal(wide, size) + normal(wide, -size))
    alone = normal(float(np.std(seen)))
    return float(np.sum(np.log(np.maximum(mixed, 1e-300)) - np.log(np.maximum(alone, 1e-300))))


def _counted(case: Case, effect: Effect) -> Effect:
    """The law's parameters as they were drawn."""
    plain = effect.plain
    if effect.name == "impulse_noise":
        spike = spikes((effect,), round(case.duration_s / TICK_S))
        first = (spike != 0.0) & (np.concatenate([[0.0], spike[:-1]]) == 0.0)
        if np.any(first):
            plain = plain.with_value("rate_hz", float(np.sum(first)) / case.duration_s)
            plain = plain.with_value("amplitude_m_s2", float(np.mean(np.abs(spike[first]))))
        return plain
    drawn = frames(case.rig, (effect,), case.duration_s, case.seed)
    if effect.name == "frame_drops":
        return plain.with_value("fraction", float(np.mean(drawn.lost)))
    had = bursts(effect, case.duration_s)
    if had:
        plain = plain.with_value("rate_hz", len(had) / case.duration_s)
        plain = plain.with_value("duration_s", float(np.mean([b[1] for b in had])))
        plain = plain.with_value("delay_s", float(np.mean([b[2] for b in had])))
    return plain
