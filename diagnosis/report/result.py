"""The result of a diagnosis: what diagnosis.json holds, and the fits that the report draws."""

from dataclasses import dataclass
from typing import Any

from stillarm.common.files.model import Model
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.decision.decide import Judged
from stillarm.diagnosis.search.candidates import Found


@dataclass(frozen=True)
class Result:
    """`table` is what diagnosis.json holds; the rest is for the report. model: as given; extended: with what was
    found."""

    table: dict[str, Any]
    found: Found
    judged: Judged
    split: Split
    model: Model
    extended: Model
