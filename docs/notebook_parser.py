"""Notebooks as pages: their text as Markdown and their code as it stands, without running it.

A Sphinx extension. The notebooks are stored without outputs, and tests execute them.
"""

import json

from docutils.nodes import document
from myst_parser.sphinx_ import Parser
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata


class NotebookParser(Parser):
    """Parser of notebooks by way of Markdown."""

    supported = ("notebook",)

    def parse(self, inputstring: str, document: document) -> None:
        """Parse a notebook into a document."""
        super().parse(markdown(inputstring), document)


def markdown(notebook: str) -> str:
    """Return the cells of a notebook as Markdown."""
    cells = json.loads(notebook)["cells"]
    return "\n\n".join(shown(cell["cell_type"], "".join(cell["source"])) for cell in cells)


def shown(kind: str, source: str) -> str:
    """Return a cell as Markdown."""
    return f"```python\n{source}\n```" if kind == "code" else source


def setup(app: Sphinx) -> ExtensionMetadata:
    """Read .ipynb files by the parser above."""
    app.add_source_suffix(".ipynb", "notebook")
    app.add_source_parser(NotebookParser)
    return {"parallel_read_safe": True}
