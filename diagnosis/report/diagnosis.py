"""The result of a diagnosis, as it is reported."""

from dataclasses import dataclass
from typing import Any

from stillarm.common.files.model import Model
from stillarm.diagnosis.data.split import Split
from stillarm.diagnosis.decision.decide import Judged
from stillarm.diagnosis.inference.candidates import Found


@dataclass(frozen=True)
class Diagnosis:
    """The result: `table` is what diagnosis.json holds; the rest is for the report."""

    table: dict[str, Any]
    found: Found
    judged: Judged
    split: Split
    model: Model
    extended: Model
