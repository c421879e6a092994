"""What to record next to tell causes apart that the data cannot."""

from stillarm.common.causes import CAUSES, experiment_between
from stillarm.common.causes.declaration import SEPARATES


def experiment(cause: str, near: list[str]) -> str:
    """The recording that separates a cause from those that explain the data as well."""
    known = (experiment_between(cause, other) for other in near)
    return next(filter(None, known), SEPARATES[CAUSES[cause].place])
