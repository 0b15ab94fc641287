"""The site answers searches: for words of the field, names of the API and topics, on the right page.

Reads the index that the search page uses, of the site in out/site, which `scripts/site` builds (in .ci/run
before the tests; it takes longer than a test may).
"""

import json
import re
from functools import cache
from pathlib import Path
from typing import TypedDict

import pytest
from fresh_checkout import ROOT

INDEX = ROOT / "out" / "site" / "searchindex.js"
pytestmark = pytest.mark.skipif(not INDEX.exists(), reason="the site is not built: scripts/site")


class SearchIndex(TypedDict):
    """What the tests read of Sphinx's search index."""

    docnames: list[str]
    terms: dict[str, int | list[int]]
    titleterms: dict[str, int | list[int]]
    objects: dict[str, list[list[object]]]


TERMS = (
    ("downwash", "downwash", "real_flights"),
    ("identify", "identifi", "tutorials/identify_your_bag"),
    ("crazyflies.yaml", "crazyfli", "tutorials/real_vehicles_with_crazyswarm2"),
    ("rosbag2", "rosbag2", "bags"),
    ("failsafe", "failsaf", "reliability"),
    ("quaternion", "quaternion", "conventions"),
    ("reference_safe", "reference_saf", "nodes/replanner"),
    ("accelerometer", "acceleromet", "correction"),
    ("lockstep", "lockstep", "conventions"),
    ("Mellinger", "melling", "onboard"),
)
"""Word typed, its stem in the index (Snowball, English), and a page that must be among the results."""


@cache
def index() -> SearchIndex:
    """Return the search index of the site."""
    text = INDEX.read_text(encoding="utf-8").removeprefix("Search.setIndex(").removesuffix(")")
    loaded: SearchIndex = json.loads(text)
    return loaded


def found(stem: str) -> set[str]:
    """Return the pages that a search for a stem lists."""
    pages: set[str] = set()
    for table in (index()["terms"], index()["titleterms"]):
        numbers = table.get(stem, [])
        pages |= {index()["docnames"][k] for k in ([numbers] if isinstance(numbers, int) else numbers)}
    return pages


@pytest.mark.parametrize(("word", "stem", "page"), TERMS, ids=[one[0] for one in TERMS])
def test_a_search_finds_the_page_that_explains_the_word(word: str, stem: str, page: str):
    assert word.lower().replace("_", "").startswith(stem.replace("_", "")[:-1])
    assert page in found(stem)


def test_a_word_that_is_nowhere_is_not_found():
    assert found("zeppelin") == set()


@pytest.mark.parametrize(
    ("module", "name"),
    [("q2q_model.bag.reader", "BagReader"), ("q2q_control.mpc.solver.riccati", "solve_from")],
)
def test_a_search_finds_the_names_of_the_api(module: str, name: str):
    assert name in {one[-1] for one in index()["objects"][module]}


def test_every_page_of_the_checkout_is_in_the_site():
    pages = {str(page.relative_to(ROOT / "docs").with_suffix("")) for page in ROOT.glob("docs/**/*.md")}
    assert pages <= set(index()["docnames"])


def test_pages_load_nothing_from_the_web():
    loads = re.compile(r'(?:<(?:script|link|img|iframe)\b[^>]*?\b(?:src|href)=|\bfrom )"(https?://[^"]*)"')
    loaded = {
        page.name: loads.findall(page.read_text(encoding="utf-8")) for page in INDEX.parent.rglob("*.html")
    }
    assert {name: found for name, found in loaded.items() if found} == {}


def test_the_site_begins_at_the_index():
    site = INDEX.parent
    assert (site / "index.html").read_bytes() == (site / "README.html").read_bytes()
    assert Path(site / "api" / "q2q_model.html").is_file()
