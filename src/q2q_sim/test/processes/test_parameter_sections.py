"""Sections of parameter files that no node reads are found if they are near to a node's name."""

from pathlib import Path

import pytest

from q2q_sim.processes.parameter_sections import misspelt_sections, section_nodes

RUNNING, ELSEWHERE = ("stack", "mocap_filter", "interference"), ("pid", "radio")


def notes(folder: Path, *names: str) -> list[str]:
    """Return the notes on a file with these sections."""
    file = folder / "file.yaml"
    file.write_text("".join(f"{name}:\n  ros__parameters: {{model: paper_law}}\n" for name in names))
    return misspelt_sections(["stack", "--ros-args", "--params-file", str(file)], RUNNING, ELSEWHERE)


def test_a_misspelt_section_is_named_with_the_node_that_was_meant(tmp_path: Path) -> None:
    (note,) = notes(tmp_path, "/**/stack", "/**/interferance", "/room/mocap_filter")
    assert note == f"{tmp_path}/file.yaml: no node reads the section interferance; did you mean interference?"


@pytest.mark.parametrize("name", ["/**", "/**/pid", "radio", "camera_driver", "/*/interference"])
def test_sections_of_all_nodes_of_others_and_of_other_processes_are_let_be(tmp_path: Path, name: str) -> None:
    assert notes(tmp_path, name) == []


def test_namespaces_may_be_levels_of_their_own() -> None:
    parameters = {"ros__parameters": {"safe": {"ros": 1}}}
    assert section_nodes({"room": {"pid": parameters, "left": {"mpc": parameters}}}) == {"pid", "mpc"}
    assert section_nodes(None) == set()
