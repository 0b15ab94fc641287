"""Pages of the API reference, one a folder: every public class, function and constant.

A Sphinx extension. griffe reads the source without importing it, so neither ROS nor the packages' own
requirements need be installed; the docstrings are Markdown, as the pages are.
"""

import json
import shutil
from ast import literal_eval
from collections.abc import Iterator
from pathlib import Path
from typing import TypeGuard

from griffe import (
    Alias,
    Attribute,
    Class,
    Docstring,
    DocstringElement,
    DocstringSectionKind,
    ExprCall,
    Function,
    GriffeLoader,
    Module,
    Object,
)
from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata

SRC = Path(__file__).parents[1] / "src"
FOLDER = "api"
LONGEST_VALUE = 60
"""Characters of a value that is shown [1]."""


def packages() -> list[str]:
    """Return the names of the packages: what users import first, then the lower ones, lowest first."""
    found = {path.parent.name for path in SRC.glob("*/*/__init__.py")}
    order = ("q2q_model", "q2q_planner", "q2q_control", "q2q_sim")
    return [*sorted(found - {*order}), *order]


def pages(package: Module) -> Iterator[tuple[str, str]]:
    """Yield the names and texts of a package's pages: its own modules, and each of its folders."""
    folders = [one for _, one in public(package) if isinstance(one, Module) and one.is_init_module]
    alone = [one for _, one in public(package) if isinstance(one, Module) and not one.is_init_module]
    for folder in folders:
        yield folder.path, page(folder, [*modules_below(folder)])
    contents = "\n".join(["```{toctree}", ":maxdepth: 1", "", *(one.path for one in folders), "```"])
    yield package.path, f"{page(package, alone)}\n{contents}\n"


def page(package: Module, modules: list[Module]) -> str:
    """Return the page of a folder."""
    lines = (line for one in modules for line in module(one))
    return "\n".join([f"# {package.path}\n", *section(package), *lines])


def modules_below(folder: Module) -> Iterator[Module]:
    """Yield the modules of a folder and of the folders inside it."""
    for _, one in public(folder):
        if isinstance(one, Module):
            yield one
            yield from modules_below(one)


def module(one: Module) -> list[str]:
    """Return the lines of a module."""
    return [f"\n## {one.path.partition('.')[2]}\n", *section(one)]


def section(one: Module) -> list[str]:
    """Return a module's docstring and its public members."""
    lines = [f"```{{py:module}} {one.path}\n```\n", *text(one.docstring)]
    for _, member in public(one):
        if not isinstance(member, Module):
            lines += entry(member, ":" * 4)
    return lines


def public(parent: Object) -> list[tuple[str, Object]]:
    """Return what a module or class defines or exports (`__all__`), without private names."""
    exported = {str(name) for name in parent.exports or ()} if isinstance(parent, Module) else set()
    members = [
        (name, one.final_target if isinstance(one, Alias) and name in exported else one)
        for name, one in parent.members.items()
    ]
    return [(name, one) for name, one in members if not name.startswith("_") and isinstance(one, Object)]


def entry(one: Object, fence: str) -> list[str]:
    """Return the directive that documents a member, and those inside it."""
    kind, signature, options = declared(one)
    inside = [line for _, member in public(one) for line in entry(member, fence[1:])] if one.is_class else []
    return [f"{fence}{{py:{kind}}} {signature}", *options, "", *meaning(one), *inside, fence, ""]


def declared(one: Object) -> tuple[str, str, list[str]]:
    """Return a member's directive, its signature and its options."""
    inside = one.parent is not None and one.parent.is_class
    if isinstance(one, Class):
        bases = [str(base) for base in one.bases]
        return "class", f"{one.name}({', '.join(bases)})" if bases else one.name, []
    if isinstance(one, Function):
        options = [f":{label}:" for label in ("classmethod", "staticmethod") if label in one.labels]
        return "method" if inside else "function", one.signature(), options
    assert isinstance(one, Attribute)
    if "property" in one.labels:
        return "property", one.name, typed(one)
    return "attribute" if inside else "data", one.name, [*typed(one), *valued(one)]


def typed(one: Attribute) -> list[str]:
    """Return the option that says an attribute's type."""
    return [f":type: {json.dumps(str(one.annotation))}"] if one.annotation is not None else []


def valued(one: Attribute) -> list[str]:
    """Return the option that says an attribute's value, where it fits a line."""
    given = one.value.arguments[0] if is_tunable(one.value) else one.value
    value = " ".join(str(given).split()) if given is not None else ""
    return [f":value: {json.dumps(value)}"] if 0 < len(value) <= LONGEST_VALUE else []


def is_tunable(value: object) -> TypeGuard[ExprCall]:
    """Return whether a field is a parameter, whose value, meaning and bounds are given by a call."""
    return isinstance(value, ExprCall) and str(value.function) == "tunable"


def meaning(one: Object) -> list[str]:
    """Return the text on a member: its docstring, or what the call says that makes it a parameter."""
    if not (isinstance(one, Attribute) and is_tunable(one.value)):
        return text(one.docstring)
    _, words, *rest = (str(argument) for argument in one.value.arguments)
    bounds = [f"`{argument}`" for argument in rest if not argument.startswith("read_only")]
    described = literal_eval(words) if words[0] in "'\"" else f"`{words}`"
    return [", ".join([described, *bounds]), ""]


def text(docstring: Docstring | None) -> list[str]:
    """Return a docstring as Markdown; its sections become lists."""
    if docstring is None:
        return []
    lines = []
    for part in docstring.parse("google", warnings=False):
        if part.kind is DocstringSectionKind.text:
            lines.append(part.value)
        elif part.kind is DocstringSectionKind.admonition:
            lines.append(f"{part.title}: {part.value.contents}")
        else:
            lines += [f"**{part.kind.value.capitalize()}**", "", *map(list_item, part.value)]
        lines.append("")
    return lines


def list_item(item: DocstringElement) -> str:
    """Return an argument, a returned value or an error of a docstring as an item of a list."""
    name = getattr(item, "name", "") or getattr(item, "annotation", "")
    return "- " + ": ".join(filter(None, (f"`{name}`" if name else "", " ".join(item.description.split()))))


def reference() -> dict[str, str]:
    """Return all pages by name; `README` lists the packages."""
    loader = GriffeLoader(search_paths=[path.parent.parent for path in SRC.glob("*/*/__init__.py")])
    made = {
        "README": "\n".join(["# API reference\n", "```{toctree}", ":maxdepth: 2", "", *packages(), "```\n"])
    }
    loaded = {name: loader.load(name, try_relative_path=False) for name in packages()}
    for package in loaded.values():
        assert isinstance(package, Module)
        made |= dict(pages(package))
    return made


def write(app: Sphinx) -> None:
    """Write all pages into the folder of the documents."""
    made, folder = reference(), Path(app.srcdir) / FOLDER
    folder.mkdir(exist_ok=True)
    for name, content in made.items():
        (folder / f"{name}.md").write_text(content, encoding="utf-8")


def remove(app: Sphinx, _: Exception | None) -> None:
    """Remove the pages: they are read from the source each time."""
    shutil.rmtree(Path(app.srcdir) / FOLDER, ignore_errors=True)


def setup(app: Sphinx) -> ExtensionMetadata:
    """Write the pages before Sphinx looks for pages."""
    app.connect("builder-inited", write)
    app.connect("build-finished", remove)
    return {"parallel_read_safe": True}
