"""What to record next to tell causes apart that the data cannot."""

from common.causes import CAUSES, experiment_between
from common.causes.declaration import SEPARATES


def experiment(cause: str, near: list[str]) -> str:
    """The recording that separates a cause from those that explain the data as well."""
    known = (experiment_between(cause, other) for other in near)
    return next(filter(None, known), SEPARATES[CAUSES[cause].place])
