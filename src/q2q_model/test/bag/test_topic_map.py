"""A topic map is read, and its mistakes are named."""

from pathlib import Path

import pytest

from q2q_model.bag import (
    BagError,
    TopicMap,
    load_topic_map,
)


def test_a_topic_map_is_read_and_its_mistakes_are_named(tmp_path: Path) -> None:
    file = tmp_path / "map.yaml"
    file.write_text("vehicles: {cf1: /a}\nposes: /poses\nrename: {cf231: cf2}\nstamps: receive\n")
    assert load_topic_map(file) == TopicMap({"cf1": "/a"}, "/poses", {"cf231": "cf2"}, {}, stamps="receive")
    for text, lines in (
        ("vehicle: {cf1: /a}", "unknown key 'vehicle'; did you mean vehicles"),
        ("vehicles: [a]", "vehicles = .*; must be a mapping of names to values"),
        ("stamps: wall\nposes: /p", "stamps = 'wall'; must be one of header, receive"),
        ("tolerance_s: -1\nposes: /p", r"tolerance_s = -1.0; must be in \[0, 1\] s"),
        ("rename: {a: b}", "maps nothing"),
        ("vehicles: {a: /p, b: /p}", "topic /p is given for vehicles.a and vehicles.b; give each its own"),
        ("vehicles: {a: /p}\nreferences: {a: /p}", "/p is given for vehicles.a and references.a; give"),
        ("poses: /p\nreferences: {a: /p}", "topic /p is given for references.a and poses; give each"),
        (
            "references: {a: /b}\nsignals: {reference: /r}",
            "references and signals: reference are both mapped",
        ),
        ("vehicles: {a: /a}\nsignals: {mocap: /m}", "vehicles and signals: mocap are both mapped; keep one"),
        ("poses: /p\nsignals: {mocap: /m}", "poses and signals: mocap are both mapped; keep one of them"),
        ("signals: {comand: /c}", "map.yaml: signals: q2q has no topic 'comand'; did you mean command"),
        ("signals: {/mocap: /m}", "q2q has no topic '/mocap'; did you mean mocap"),
        ("signals: {plan: /p}", "no topic 'plan'; choose one of mocap, truth, .*, command"),
        ("[1, 2]", "expected a mapping"),
        ("{", "is not valid YAML: line 1"),
    ):
        file.write_text(text)
        with pytest.raises(BagError, match=lines):
            load_topic_map(file)
