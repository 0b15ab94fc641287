"""Find the file of an interaction model by its name, without reading it."""

from pathlib import Path

SUFFIX = ".q2q"
NONE = "none"
"""The model without a file: no downwash."""


class ModelFileError(ValueError):
    """Error for a model file that cannot be used."""


def model_path(name: str, shipped: Path) -> Path | None:
    """Return the file of the model called `name`: a shipped one's name, or a path; None for "none".

    Args:
        name: what the user gave.
        shipped: folder of the shipped files, share/q2q_model/config where installed.

    Raises:
        ModelFileError: there is no such model.
    """
    if name == NONE:
        return None
    named = shipped / f"{name}{SUFFIX}"
    if Path(name).name == name and named.is_file():
        return named
    if Path(name).is_file():
        return Path(name)
    known = ", ".join(sorted({NONE} | {path.stem for path in shipped.glob(f"*{SUFFIX}")}))
    raise ModelFileError(f"no model {name!r}: give one of {known}, or the path of a {SUFFIX} file")
