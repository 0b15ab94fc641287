"""Names of interaction models and their files, checked without the imports that models need."""

from pathlib import Path

from q2q_model.documents.shipped_folder import shipped_folder, shipped_or_given

SUFFIX = ".q2q"
NONE = "none"
"""Name of the model without downwash, which has no file."""


class ModelFileError(ValueError):
    """Error for a model file that does not exist or is not valid."""


def check_model_name(name: str) -> None:
    """Raise ModelFileError if no shipped model or file has this name."""
    model_path(name)


def model_path(name: str) -> Path | None:
    """Return the file of a model, given by the name of a shipped one or by its path; None for "none".

    Raises:
        ModelFileError: the model does not exist.
    """
    if name == NONE:
        return None
    shipped = shipped_models()
    if (found := shipped_or_given(name, shipped / f"{name}{SUFFIX}")) is not None:
        return found
    known = ", ".join(sorted({NONE} | {path.stem for path in shipped.glob(f"*{SUFFIX}")}))
    raise ModelFileError(f"no model {name!r}: give one of {known}, or the path of a {SUFFIX} file")


def shipped_models() -> Path:
    """Return the folder of the shipped `.q2q` files."""
    return shipped_folder(Path(__file__).resolve().parents[1])
