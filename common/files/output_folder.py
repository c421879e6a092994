"""A folder for results: made where it is missing, refused in one line where that cannot be."""

from pathlib import Path

from stillarm.common.user_error import UserError, reason_of


def make_folder(path: str | Path) -> Path:
    """Make a folder and those above it; one that exists is taken as it is. Raises UserError."""
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"{path}: cannot be made a folder ({reason_of(error)}); name a folder that you may write to"
        ) from None
    return path
