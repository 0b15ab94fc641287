"""Tests of the model file: round trip, and one clear error for every fault."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from q2q_model.documents.checksummed_json import LONGEST
from q2q_model.downwash.envelope_network import EnvelopeNetwork, Network
from q2q_model.downwash.interaction_model import InteractionModel, pairs_at_rest
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, PAPER_LAW, Jet
from q2q_model.downwash.level_set import LevelSet, level_set
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.geometry.zone import Cylinder, Ellipsoid
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_file import Fit, ModelFile, RoleScores, decode, encode, load, save
from q2q_model.model_files.model_names import ModelFileError, shipped_models
from q2q_model.vehicle.altitude_loop import PAPER_LOOP


def _networks() -> EnvelopeNetwork:
    rng = np.random.default_rng(9)
    lower, upper = (
        Network(rng.normal(size=(40, 2)), rng.normal(size=40), rng.normal(size=40), 0.1) for _ in range(2)
    )
    return EnvelopeNetwork(lower, upper)


FIT = Fit(
    method="adam",
    flights=("a", "b"),
    held_out=("c",),
    train_mse_m2=RoleScores(1e-3, 2e-3),
    heldout_r2=RoleScores(0.9, None),
)


@pytest.mark.parametrize("law", [NoInteraction(), PAPER_LAW, MEASURED_LAW, _networks()])
def test_a_saved_model_predicts_the_same_to_the_last_digit(law: InteractionModel, tmp_path: Path):
    path = tmp_path / "new" / "folder" / "model.q2q"
    save(path, ModelFile(law, Cylinder(0.2, 0.9), PAPER_LOOP, FIT))
    again = load(path)
    rel_pos = np.random.default_rng(10).normal(size=(20, 3)) * 0.3
    expected = law.acceleration(rel_pos, pairs_at_rest(rel_pos))
    np.testing.assert_array_equal(again.interaction.acceleration(rel_pos, pairs_at_rest(rel_pos)), expected)
    assert (again.zone, again.gains, again.fit) == (Cylinder(0.2, 0.9), PAPER_LOOP, FIT)


def test_zones_of_every_kind_survive():
    assert decode(encode(ModelFile(PAPER_LAW, Ellipsoid(0.2, 1.0)))).zone == Ellipsoid(0.2, 1.0)
    zone = level_set(PAPER_LAW, 0.1)
    again = decode(encode(ModelFile(PAPER_LAW, zone))).zone
    assert isinstance(again, LevelSet)
    np.testing.assert_array_equal(again.table, zone.table)


def test_a_file_cut_anywhere_is_one_clear_error():
    text = encode(ModelFile(PAPER_LAW))
    for end in range(0, len(text) - 2, 7):
        with pytest.raises(ModelFileError, match="not complete JSON"):
            decode(text[:end])


def test_a_text_beyond_the_bound_is_refused_before_it_is_parsed():
    with pytest.raises(ModelFileError, match=f"{LONGEST + 1} characters; must be at most {LONGEST}"):
        decode("[" * (LONGEST + 1))


def test_entries_nested_too_deeply_to_be_read_or_summed_up_are_refused():
    """Some depths are read and not written: the checksum of these exceeded the recursion limit."""
    text = encode(ModelFile(PAPER_LAW))
    limit = sys.getrecursionlimit()
    for depth in range(limit - 150, limit + 10):
        with pytest.raises(ModelFileError, match=r"checksum does not match|nested too deeply|recursion"):
            decode(text.replace('"fit": null', f'"fit": {"[" * depth}{"]" * depth}'))


def test_an_edited_number_is_found_by_the_checksum():
    text = encode(ModelFile(PAPER_LAW))
    with pytest.raises(ModelFileError, match="checksum does not match"):
        decode(text.replace("0.392", "0.492"))


def _rechecksummed(change: dict[str, object]) -> str:
    """Return a file with top entries changed and the right checksum for them."""
    from q2q_model.documents.checksummed_json import checksum

    body = json.loads(encode(ModelFile(PAPER_LAW))) | change
    body.pop("checksum")
    body = {name: value for name, value in body.items() if value is not ...}
    return json.dumps(body | {"checksum": checksum(body)})


NEW_IN = {1: ("std_floor", "velocity_share", "loading", "absorption"),
          2: ("velocity_share", "loading", "absorption")}  # fmt: skip
"""Parameters of a jet that files of a version lack."""


@pytest.mark.parametrize("version", NEW_IN)
def test_a_jet_of_an_old_version_is_read_as_one_without_the_parameters_that_came_later(version: int):
    made = Jet(strength=0.5, relative_std=0.2)
    old = json.loads(encode(ModelFile(made)))["model"]
    for name in NEW_IN[version]:
        del old["parameters"][name]
    assert decode(_rechecksummed({"version": version, "model": old})).interaction == made


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"format": "onnx"}, 'should be "q2q-model"'),
        ({"version": 5}, "version 5 is unknown"),
        ({"zone": ...}, "entry 'zone' is missing"),
        (
            {"model": {"type": "os.system", "parameters": {}}},
            r"'os\.system': choose one of none",
        ),
        ({"model": {"type": ["jet"], "parameters": {}}}, "choose one of"),
        ({"model": 3}, r"model\.type is 3"),
        ({"model": {"type": "jet"}}, r"model\.parameters: got None, expected a mapping"),
        (
            {"model": {"type": "jet", "parameters": {"width": "wide"}}},
            r"width = 'wide'; must be a number",
        ),
        ({"model": {"type": "jet", "parameters": {"width": True}}}, "width = True; must be a number"),
        (
            {"model": {"type": "jet", "parameters": {"width": float("nan")}}},
            "width = nan; must be a finite number",
        ),
        ({"model": {"type": "jet", "parameters": {"width": 99.0}}}, r"Jet\.width = 99\.0; must be in \["),
        (
            {"model": {"type": "jet", "parameters": {"with": 0.1}}},
            r"model\.parameters: unknown key 'with'; did you mean width",
        ),
        ({"model": {"type": "envelope_network", "parameters": {"lower": {}}}}, "is missing"),
        ({"gains": {"k_p": 1.0}}, r"gains: k_d is missing"),
        ({"gains": [1.0, 2.0]}, "gains: got .*, expected a mapping with k_p"),
        ({"fit": {"method": 1, "flights": []}}, "fit: method = 1; must be text"),
        ({"zone": {"type": "level_set", "parameters": {"threshold": 50.0}}}, "the downwash's peak"),
    ],
)
def test_every_wrong_entry_is_named(change: dict[str, object], says: str):
    with pytest.raises(ModelFileError, match=says):
        decode(_rechecksummed(change))


def test_ragged_weights_are_refused():
    text = encode(ModelFile(_networks()))
    body = json.loads(text)
    body["model"]["parameters"]["lower"]["hidden_weights"][3] = [1.0]
    with pytest.raises(ModelFileError, match="rows of one length"):
        decode(_rechecksummed({"model": body["model"]}))


def test_a_model_with_nan_is_not_written(tmp_path: Path):
    broken = Network(np.full((40, 2), np.nan), np.zeros(40), np.zeros(40), 0.0)
    with pytest.raises(ModelFileError, match=r"model\.lower\.hidden_weights\[0\]\[0\] = nan"):
        save(tmp_path / "model.q2q", ModelFile(EnvelopeNetwork(broken, broken)))
    assert not (tmp_path / "model.q2q").exists()


def test_files_that_cannot_be_read_are_model_file_errors(tmp_path: Path):
    binary = tmp_path / "binary.q2q"
    binary.write_bytes(b"\xff\xfe\x00")
    for path in (tmp_path / "missing.q2q", tmp_path, binary):
        with pytest.raises(ModelFileError, match=r": cannot be read \(") as refusal:
            load(path)
        assert str(refusal.value).count(path.name) == 1  # the system's error names it, too


def test_models_are_found_by_name_by_path_and_otherwise_the_known_names_are_reported(tmp_path: Path):
    assert isinstance(find_model("none").interaction, NoInteraction)
    assert find_model("paper_law").interaction == PAPER_LAW
    assert find_model("measured_law").interaction == MEASURED_LAW
    assert find_model("moving_law").interaction == MOVING_LAW
    own = tmp_path / "own.q2q"
    save(own, ModelFile(Jet(strength=0.7)))
    assert find_model(str(own)).interaction == Jet(strength=0.7)
    with pytest.raises(ModelFileError, match="give one of measured_law, moving_law, none, paper_law"):
        find_model("paper_low")


def test_an_installed_folder_is_preferred_to_the_source_tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    installed = tmp_path / "share" / "q2q_model" / "config"
    installed.mkdir(parents=True)
    save(installed / "paper_law.q2q", ModelFile(Jet(strength=0.1)))
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'empty'}:{tmp_path}")
    assert find_model("paper_law").interaction == Jet(strength=0.1)
    monkeypatch.setenv("AMENT_PREFIX_PATH", "")
    assert find_model("paper_law").interaction == load(shipped_models() / "paper_law.q2q").interaction


def test_models_with_tables_can_be_compared_and_hashed() -> None:
    one, other = (find_model("measured_law") for _ in range(2))
    assert one == one  # noqa: PLR0124
    assert one != other or one.zone is other.zone
    assert hash(one.zone) == hash(one.zone)
