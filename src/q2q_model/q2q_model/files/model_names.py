"""Lookup of an interaction model's file by name, without reading it."""

from pathlib import Path

from q2q_model.files.shipped_folder import shipped_or_given

SUFFIX = ".q2q"
NONE = "none"
"""Name of the model without downwash, which has no file."""


class ModelFileError(ValueError):
    """Error for a model file that does not exist or is not valid."""


def model_path(name: str, shipped: Path) -> Path | None:
    """Return the file of a model, given by the name of a shipped one or by its path; None for "none".

    Args:
        name: name or path.
        shipped: folder of the shipped files.

    Raises:
        ModelFileError: the model does not exist.
    """
    if name == NONE:
        return None
    if (found := shipped_or_given(name, shipped / f"{name}{SUFFIX}")) is not None:
        return found
    known = ", ".join(sorted({NONE} | {path.stem for path in shipped.glob(f"*{SUFFIX}")}))
    raise ModelFileError(f"no model {name!r}: give one of {known}, or the path of a {SUFFIX} file")
