"""Configuration of the site: Sphinx with MyST, as for the documentation of ROS, and a theme that fits phones.

The navigation is read from the tables of README.md, whose headings are its captions; the pages of `api/` are
made by `api_reference` from the source before they are read, and removed afterwards.
"""

import re
import shutil
import sys
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS))

project = "q2q"
author = "q2q developers"
root_doc = "README"
extensions = ["myst_parser", "api_reference", "notebook_parser"]
html_theme = "furo"
html_title = "q2q"
html_show_copyright = False
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_search_scorer = str(DOCS / "static" / "search_order.js")
toc_object_entries = False  # a page lists its modules; its objects are found by search and index
smartquotes = False  # x' is a derivative
nitpicky = False  # types of other packages are not linked
suppress_warnings = ["ref.python"]  # a type's short name that several modules define is linked to the first

myst_enable_extensions = ["colon_fence"]
myst_disable_syntax = ["html_inline"]  # <name> in a docstring is text
myst_heading_anchors = 4

CAPTION = re.compile(r"^## (.*)$", re.MULTILINE)
PAGE = re.compile(r"\]\(([\w/]+)\.md(?:#[\w-]*)?\)")
NOTEBOOK = re.compile(r"\]\(([\w/]+)\.ipynb\)")


def add_navigation(_: Sphinx, name: str, source: list[str]) -> None:
    """Append to a folder's README a table of contents for each heading: the pages linked below it.

    Notebooks belong to the page that links to them.
    """
    if not name.endswith("README"):
        source[0] += toctree("", NOTEBOOK.findall(source[0]))
        return
    top, *parts = CAPTION.split(source[0])
    groups = [*zip(parts[::2], parts[1::2], strict=True)]
    groups += [("API", "[API reference](api/README.md)")] if name == root_doc else [("", top)]
    listed: set[str] = set()
    for caption, text in groups:
        pages = [page for page in dict.fromkeys(PAGE.findall(text)) if page not in listed]
        source[0] += toctree(caption, pages)
        listed |= {*pages}


def toctree(caption: str, pages: list[str]) -> str:
    """Return a hidden table of contents; nothing where there are no pages."""
    if not pages:
        return ""
    options = [f":caption: {caption}"] if caption else []
    return "\n".join(["\n```{toctree}", *options, ":hidden:", "", *pages, "```\n"])


def copy_index(app: Sphinx, failure: Exception | None) -> None:
    """Give the index the name under which web servers look for it."""
    if failure is None and app.builder.format == "html":
        shutil.copy(Path(app.outdir) / f"{root_doc}.html", Path(app.outdir) / "index.html")


def setup(app: Sphinx) -> ExtensionMetadata:
    """Connect the two steps above."""
    app.connect("source-read", add_navigation)
    app.connect("build-finished", copy_index)
    return {"parallel_read_safe": True}
