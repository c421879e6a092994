"""Tables for a terminal."""

from typing import Any


def print_rows(rows: list[dict[str, Any]]) -> None:
    """Print a table with a column for each key of the first row."""
    keys = list(rows[0])
    texts = [[_text(row.get(key)) for key in keys] for row in rows]
    widths = [max(len(key), *(len(text[i]) for text in texts)) for i, key in enumerate(keys)]
    print("  ".join(key.ljust(width) for key, width in zip(keys, widths, strict=True)))
    for text in texts:
        print("  ".join(cell.ljust(width) for cell, width in zip(text, widths, strict=True)))


def _text(value: object) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def brief_estimator_row(row: dict[str, Any]) -> dict[str, Any]:
    """The columns that fit a terminal, under short names; the file of --json has all columns."""
    row = row | {f"{name}_error": error for name, error in row.get("standard_errors", {}).items()}
    brief = {short: row[name] for name, short in _SHORT.items() if name in row}
    return brief if row.get("failure") is None else brief | {"trials": f"{brief['trials']}: {row['failure']}"}


_SHORT = {
    "condition": "condition",
    "regime": "regime",
    "noise": "noise",
    "method": "method",
    "error_mean": "err_mean",
    "error_max": "err_max",
    "bound_deflection": "err_bound",
    "error_last": "err_last",
    "error_max_all": "max_all",
    "error_mean_during": "err_during",
    "error_max_during": "max_during",
    "pmcc": "pmcc",
    "delay_bias_s": "bias_s",
    "delay_rms_s": "rms_s",
    "bound_s": "bound_s",
    "ratio": "ratio",
    "ratio_error": "+-",
    "delay_normalised_error_squared": "nes_delay",
    "deflection_normalised_error_squared": "nes_defl",
    "delay_normalised_error_squared_during": "nes_delay_during",
    "deflection_normalised_error_squared_during": "nes_defl_during",
    "unanswered_during": "mute_during",
    "us_per_cycle": "us",
    "us_per_cycle_median": "us_median",
    "settling_time_s": "settling_s",
    "settling_over_oracle": "/ oracle",
    "residual": "residual",
    "residual_over_oracle": "/ oracle's",
    "trials": "trials",
}
