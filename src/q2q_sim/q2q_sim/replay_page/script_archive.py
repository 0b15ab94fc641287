"""Scripts and style of the page as one compressed text.

The modules are listed so that each follows those that it imports; `player/loader.js` makes them importable in
the browser under these names.
"""

import json
import zlib
from base64 import b64encode
from functools import cache
from pathlib import Path

FOLDER = Path(__file__).parent
THREE = {
    "./three.core.min.js": "three.core.min.js",
    "three": "three.module.min.js",
    "three/OrbitControls": "OrbitControls.js",
    "./LineSegmentsGeometry.js": "LineSegmentsGeometry.js",
    "./LineMaterial.js": "LineMaterial.js",
    "three/LineSegments2": "LineSegments2.js",
}
"""Import name -> file in `three/`."""
PLAYER = (
    "colours",
    "recorded_run",
    "playback",
    "room",
    "vehicles",
    "zones",
    "references",
    "trails",
    "air",
    "mocap_samples",
    "painter",
    "controls",
    "short_names",
    "labels",
    "run_view",
    "pointing",
    "keys",
    "moments",
    "height_curves",
    "readout",
    "replay_element",
)
"""Modules of `player/`; the last defines the element."""


@cache
def script_archive() -> str:
    """Return modules and style as base64 of zlib-compressed JSON."""
    modules = [[name, _text("three", file)] for name, file in THREE.items()]
    modules += [[f"./{name}.js", _text("player", f"{name}.js")] for name in PLAYER]
    archive = {"modules": modules, "style": _text("player", "replay.css")}
    return b64encode(zlib.compress(json.dumps(archive).encode(), 9)).decode()


def loader() -> str:
    """Return the script that unpacks the archive in the browser."""
    return _text("player", "loader.js")


def _text(folder: str, name: str) -> str:
    return (FOLDER / folder / name).read_text(encoding="utf-8")
