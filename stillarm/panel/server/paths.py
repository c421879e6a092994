"""Names that a page may ask for, confined to one folder."""

from pathlib import Path

_LONGEST = 255


def confined(folder: Path, name: str, suffixes: tuple[str, ...]) -> Path | None:
    """The file `name` that lies directly in `folder`, or None where it is no such file.

    A separator, a parent, a hidden name, another suffix, or a link that leads out of the folder is no such file.
    """
    if not name or len(name) > _LONGEST or name.startswith(".") or not name.isprintable():
        return None
    if "/" in name or "\\" in name or Path(name).suffix not in suffixes:
        return None
    root = folder.resolve()
    try:
        path = (root / name).resolve(strict=True)
    except (OSError, RuntimeError, ValueError):
        return None
    return path if path.parent == root and path.is_file() else None
