"""Diagnoses several recordings of one driven rig together: what is common is fitted once."""

import time
from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stillarm.commands.recordings.diagnose_many import Done, Job
from stillarm.common.process.blas_threads import one_blas_thread
from stillarm.common.user_error import UserError

if TYPE_CHECKING:
    from stillarm.diagnosis.driven.recording.signals import Driven

_FEWEST = 2


def of_one_rig(jobs: Sequence[Job]) -> list[Job]:
    """Those whose recordings hold a joint that a torque, a current or a voltage drives, where there are two or more.

    A file that cannot be read is none of them: its own job says what is wrong with it.
    """
    from stillarm.common.recording.reader import open_recording
    from stillarm.diagnosis.driven.recording.signals import is_driven

    found = []
    for job in jobs:
        try:
            if is_driven(open_recording(job.path)):
                found.append(job)
        except UserError:
            continue
    return found if len(found) >= _FEWEST else []


def diagnose_together(jobs: Sequence[Job], folder: Path) -> list[Done]:
    """Run the jobs of one rig's recordings as one. The rig's own files go to `folder`, each recording's view to its
    job's. The first result is the rig's. An error in one recording is returned, and stops no other."""
    one_blas_thread()
    began_s = time.monotonic()
    from stillarm.commands.recordings.diagnose_result import sentence, write_driven, write_view
    from stillarm.common.files.output_folder import make_folder
    from stillarm.common.recording.reader import open_recording
    from stillarm.diagnosis.decision.budget import Budget
    from stillarm.diagnosis.diagnose import model_of
    from stillarm.diagnosis.driven.recording.signals import read_driven
    from stillarm.diagnosis.driven.together.rig import diagnose_rig

    failed: list[Done] = []
    read: list[tuple[Job, Driven]] = []
    incomplete: dict[str, str] = {}
    model = jobs[0].model
    for job in jobs:
        try:
            recording = open_recording(job.path)
            read.append((job, read_driven(recording)))
            incomplete[job.path.stem] = recording.incomplete
            if model is None and recording.header.model.strip():
                model = model_of(recording)
        except UserError as error:
            failed.append(Done(job, str(error), failed=True))
    budget = Budget(jobs[0].budget_s, began_s)

    def left_s() -> float:
        return inf if budget.seconds is None else budget.stages_s - budget.used_s

    if not read:
        return failed
    good, drivens = [job for job, _ in read], [driven for _, driven in read]
    labels = [job.path.stem for job in good]
    try:
        result = diagnose_rig(drivens, labels, model, good[0].hold_out, left_s=left_s)
        lost = "; ".join(f"{stem}: {what}" for stem, what in incomplete.items() if what)
        result.rig.table["looked_at"] |= {
            "seconds": budget.used_s,
            "budget_s": budget.seconds,
            "incomplete": lost,
        }
        write_driven(result.rig, make_folder(folder))
        for job, view, extended in zip(good, result.views, result.extended, strict=True):
            write_view(view, extended, make_folder(job.folder))
    except UserError as error:
        return [*failed, *(Done(job, str(error), failed=True) for job in good)]
    whole = Done(
        Job(folder, folder, model, good[0].hold_out, 0, good[0].budget_s),
        f"{len(good)} recordings of one rig: {sentence(result.rig.table)}{_made_worse(result.rig.table)}",
    )
    each = [Done(job, sentence(view), has_report=False) for job, view in zip(good, result.views, strict=True)]
    return [whole, *failed, *each]


def _made_worse(table: dict[str, Any]) -> str:
    worse = [row["recording"] for row in table["recordings"] if row["worse"]]
    return f"; the extended model foretells {', '.join(worse)} worse than the plain one" if worse else ""
