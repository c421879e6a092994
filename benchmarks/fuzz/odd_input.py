"""Fuzzes the step with odd values and pauses: `python -m stillarm.benchmarks.fuzz.odd_input --minutes 10 --seed 1`.

Each method in turn runs plans of odd values (odd_plans.py) in child processes. A finding is printed as the smallest
plan that still shows it. Needs hypothesis: `pip install stillarm[dev]`.
"""

import argparse
import sys
import time
from itertools import count

from stillarm.benchmarks.fuzz.odd_child import run_in_child
from stillarm.benchmarks.fuzz.odd_world import Plan, Verdict, World, warmed
from stillarm.common.process.blas_threads import one_blas_thread
from stillarm.controller.estimation.methods import METHODS

_BATCH = 25  # plans


def complaints(verdict: Verdict, usual: Verdict) -> list[str]:
    """The faults of a run, compared with the same run without odd values."""
    found = list(verdict.faults)
    if verdict.failures:
        found.append(f"the method's numbers failed {verdict.failures} times")
    if left := set(verdict.not_numbers) - set(usual.not_numbers):
        found.append(f"NaN is left in {sorted(left)}")
    return found


class OddValues(AssertionError):
    """A plan caused a fault."""


def check(world: World, plan: Plan, usual: Verdict) -> None:
    """Raises OddValues with the complaints about a plan."""
    found = complaints(run_in_child(world, plan, usual.error), usual)
    if found:
        raise OddValues(f"{plan}: {'; '.join(found)}")


def batch_of(world: World, usual: Verdict, batch_seed: int) -> int:
    """Run a batch of plans. Returns the number of runs.

    Raises OddValues with the smallest plan that causes a fault.
    """
    from hypothesis import HealthCheck, Phase, given, seed, settings

    from stillarm.benchmarks.fuzz.odd_plans import plans

    runs = 0

    @seed(batch_seed)
    @settings(
        max_examples=_BATCH,
        deadline=None,
        database=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )
    @given(plan=plans())
    def run_all(plan: Plan) -> None:
        nonlocal runs
        runs += 1
        check(world, plan, usual)

    run_all()
    return runs


def fuzz(minutes: float, first_seed: int) -> int:
    """Fuzz for a time. Returns the number of findings."""
    until_s = time.monotonic() + 60.0 * minutes
    worlds = {name: warmed(name) for name in METHODS}
    usual = {name: run_in_child(world, Plan(()), None) for name, world in worlds.items()}
    findings = runs = 0
    for batch in count():
        if time.monotonic() > until_s:
            break
        name = list(METHODS)[batch % len(METHODS)]
        try:
            runs += batch_of(worlds[name], usual[name], first_seed + batch)
        except OddValues as finding:
            findings += 1
            print(f"seed {first_seed + batch}, {name}: {finding}", flush=True)
    print(f"seed {first_seed}: {runs} plans in batches without a finding, {findings} findings")
    return findings


def main(words: list[str]) -> int:
    """Run the command line. Returns 0 without a finding."""
    parser = argparse.ArgumentParser(prog="python -m stillarm.benchmarks.fuzz.odd_input", description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(words)
    one_blas_thread()
    try:
        return 1 if fuzz(asked.minutes, asked.seed) else 0
    except ModuleNotFoundError as missing:
        print(
            f"stillarm.benchmarks.fuzz: {missing.name} is missing; install it with `pip install stillarm[dev]`",
            file=sys.stderr,
        )
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
