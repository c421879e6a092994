"""Runs each plan of odd values in a separate child process, which the kernel ends if it computes for too long.

The child is a fork, so that it begins with a warm estimator. Its deadline is processor time, so that a busy machine
causes no finding.
"""

import gc
import os
import pickle
import resource
import signal
import traceback

from stillarm.benchmarks.fuzz.odd_world import Odd, Plan, Verdict, World, run

DEADLINE_S = 20  # of processor time; a run takes 0.2 to 0.6 s
STEP_S = 0.002  # longest allowed step
_REPEATS = 4  # the minimum over this many runs removes interrupts and cold caches


def run_in_child(world: World, plan: Plan, usual_error: float | None) -> Verdict:
    """Run the plan in a fork. If the child hangs, dies or raises, the verdict has that fault."""
    verdict = _run_once(world, plan, usual_error, touch=False)
    least = verdict.step_ns
    for _ in range(_REPEATS - 1):
        if not least or max(least) <= STEP_S * 1e9:
            break
        least = [
            min(pair)
            for pair in zip(least, _run_once(world, plan, usual_error, touch=True).step_ns, strict=False)
        ]
    if least and max(least) > STEP_S * 1e9:
        verdict.faults.append(f"a step of {max(least) / 1e6:.1f} ms in cycle {least.index(max(least))}")
    return verdict


def _run_once(world: World, plan: Plan, usual_error: float | None, *, touch: bool) -> Verdict:
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        _be_the_child(writer, world, plan, usual_error, touch)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        told = pipe.read()
    _, status = os.waitpid(child, 0)
    if told:
        verdict: Verdict = pickle.loads(told)
        return verdict
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL):
        return Verdict([f"hangs: {DEADLINE_S} s of processor time were not enough"])
    return Verdict([f"the child died with status {status}"])


def _touch() -> None:
    """Step through a start and a pause with a method of each kind, so that the fork's page copies do not count as work
    of a step.
    """
    for method in ("correlation", "kalman_fusion", "fused"):
        other = World(method)
        run(other, Plan((Odd(20, "pause", 2000),)), further=40)


def _be_the_child(writer: int, world: World, plan: Plan, usual_error: float | None, touch: bool) -> None:
    """Never returns."""
    status = 1
    try:
        used = resource.getrusage(resource.RUSAGE_SELF)
        deadline = int(used.ru_utime + used.ru_stime) + DEADLINE_S
        resource.setrlimit(resource.RLIMIT_CPU, (deadline, deadline + 1))
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        gc.disable()  # as the loop does
        if touch:
            _touch()
        try:
            verdict = run(world, plan, usual_error)
        except Exception:
            verdict = Verdict([f"raises: {traceback.format_exc(limit=-3)}"])
        with os.fdopen(writer, "wb") as pipe:
            pipe.write(pickle.dumps(verdict))
        status = 0
    finally:
        os._exit(status)
