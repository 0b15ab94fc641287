"""Find interaction models by name: those shipped with the package, installed or in the source tree."""

from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.files.model_choice import shipped_models
from q2q_model.files.model_file import ModelFile, load
from q2q_model.files.model_names import model_path


def find_model(name: str) -> ModelFile:
    """Return the model called "none", a shipped one by its name, or one by its path.

    Raises:
        ModelFileError: there is no such model, or its file cannot be used.
    """
    path = model_path(name, shipped_models())
    return ModelFile(interaction=NoInteraction()) if path is None else load(path)
