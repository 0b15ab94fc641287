"""Lookup of interaction models by name or path."""

from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.model_files.model_file import ModelFile, load
from q2q_model.model_files.model_names import model_path


def find_model(name: str) -> ModelFile:
    """Return the model "none", a shipped model by its name, or a model by its path.

    Raises:
        ModelFileError: the model does not exist, or its file is not valid.
    """
    path = model_path(name)
    return ModelFile(interaction=NoInteraction()) if path is None else load(path)
