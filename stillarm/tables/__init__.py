"""Rectangular files of any format: columns in, guesses at what they are, an import description, a recording out.

`readers/` open the formats, `guesses/` judge values alone, `description.py` is what the user corrects. Not here: the
CSV bundle, whose columns are known (common/csv_bundle). Begin with `table.py`.
"""

__all__ = [
    "described",
    "description",
    "drawing",
    "guesses",
    "importing",
    "readers",
    "report",
    "roles",
    "table",
    "unscaled",
]
