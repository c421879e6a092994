"""Output of an identification: the parameters on the terminal, the model in a file."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from stillarm.common.user_error import UserError

if TYPE_CHECKING:
    from stillarm.common.files.model import Model


def print_parameters(parameters: Mapping[str, tuple[float, float]]) -> None:
    """Print one line per parameter: name, value, standard deviation."""
    for key, (value, std) in parameters.items():
        print(f"  {key:<34} {value:>12.6g} +- {std:.2g}")


def write_model(model: "Model", path: Path) -> None:
    """Write the model file. Raises UserError if it cannot be written."""
    from stillarm.diagnosis.report.extended_model import model_text

    try:
        path.write_text(model_text(model))
    except OSError as error:
        raise UserError(f"{path}: cannot be written ({error.strerror}); name another file with -o") from None
