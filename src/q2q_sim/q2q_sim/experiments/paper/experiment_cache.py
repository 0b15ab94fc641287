"""Cache of finished experiments, from which interrupted runs resume."""

import json
from hashlib import sha256
from importlib import import_module
from pathlib import Path

from q2q_model.documents.shipped_folder import shipped_folder
from q2q_model.documents.written_file import write_text
from q2q_sim.experiments.paper.experiment_outcome import ExperimentOutcome, FigurePicture
from q2q_sim.q2q_packages import PACKAGES

SUFFIXES = (".py", ".yaml", ".q2q", ".air")
"""Files whose content affects the results: code, parameters, models and airs."""


class PaperCache:
    """Folder of outcomes with the fingerprint of their code."""

    def __init__(self, out: Path, code: str) -> None:
        """Take the output folder and the fingerprint of the code."""
        self._out = out
        self._code = code

    def folder(self, name: str) -> Path:
        """Return the folder for an experiment's pictures."""
        return self._out / name

    def load(self, name: str) -> ExperimentOutcome | None:
        """Return an outcome; None if it is missing, of other code, or damaged."""
        try:
            kept = json.loads(self._file(name).read_text(encoding="utf-8"))
            if kept["code"] != self._code:
                return None
            outcome = ExperimentOutcome(
                kept["values"], tuple(FigurePicture(*one) for one in kept["pictures"])
            )
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return None
        whole = all((self.folder(name) / Path(one.file).name).is_file() for one in outcome.pictures)
        return outcome if whole else None

    def save(self, name: str, outcome: ExperimentOutcome) -> None:
        """Save an outcome atomically."""
        pictures = [[one.group, one.file, one.caption] for one in outcome.pictures]
        kept = {"code": self._code, "values": dict(outcome.values), "pictures": pictures}
        write_text(json.dumps(kept, indent=1), self._file(name))

    def _file(self, name: str) -> Path:
        return self._out / "cache" / f"{name}.json"


def fingerprint() -> str:
    """Return a hash of the code and data of all packages except the nodes, which the paper does not use."""
    total = sha256()
    for package in PACKAGES:
        root = Path(import_module(package).__path__[0])
        for folder in (root, shipped_folder(root)):
            for path in sorted(folder.rglob("*")):
                if path.suffix in SUFFIXES and "ros" not in path.relative_to(folder).parts:
                    total.update(str(path.relative_to(folder)).encode())
                    total.update(path.read_bytes())
    return total.hexdigest()
