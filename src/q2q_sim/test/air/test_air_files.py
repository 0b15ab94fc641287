"""Tests of air files and names: round trip, and every refusal in one sentence that says what to do."""

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from room_flights import WHOLE

from q2q_model.documents.checksummed_json import checksum
from q2q_model.vehicle.constants import GRAVITY
from q2q_sim.air.air_file import decode, encode, load, save
from q2q_sim.air.air_names import LAWS, SYNTHETIC, AirError, check_air
from q2q_sim.air.lookup.find_air import find_air
from q2q_sim.air.room_air import TERMS, RoomAir, without_terms
from q2q_sim.air.term_bounds import ABOVE_ZERO, ACCELERATIONS, NOT_NEGATIVE
from q2q_sim.air.wake_laws import WakeLaw


def test_an_air_comes_back_from_its_file(tmp_path: Path) -> None:
    path = tmp_path / "room.air"
    air = RoomAir(
        WHOLE.jet, residual=WHOLE.residual, flights=("a", "b"), intervals={"residual.time_s": (0.07, 0.09)}
    )
    save(path, air)
    found = load(path)
    assert encode(found) == encode(air)
    assert found.jet is not None
    np.testing.assert_array_equal(found.jet.push_mps2, air.jet.push_mps2)
    assert found.wind is None
    assert found.intervals == {"residual.time_s": (0.07, 0.09)}


def test_a_file_cut_anywhere_is_refused() -> None:
    text = encode(WHOLE)
    for end in range(0, len(text) - 2, 97):
        with pytest.raises(AirError, match=r"not complete JSON .*create it again with learn_air"):
            decode(text[:end])


def test_an_edited_number_is_found_by_the_checksum() -> None:
    with pytest.raises(AirError, match="checksum does not match"):
        decode(encode(WHOLE).replace("0.28", "0.29"))


def _rechecksummed(change: dict[str, object]) -> str:
    body = json.loads(encode(WHOLE))
    body.pop("checksum")
    body["air"] |= change
    return json.dumps(body | {"checksum": checksum(body)})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"storm": {}}, r"air: unknown key 'storm'; choose one of jet"),
        (
            {"residual": {"floor_mps2": float("nan"), "slope": 0.1, "time_s": 0.1}},
            "floor_mps2 = nan; must be a finite number",
        ),
        ({"residual": {"floor_mps2": 0.1, "slope": 0.1}}, "residual.time_s is missing"),
        (
            {"ground": {"coefficient": 0.8, "rotor_radius_m": 0.02, "lowest_m": 0.0}},
            "lowest_m = 0.0; must be above",
        ),
        (
            {"jet": {**json.loads(encode(WHOLE))["air"]["jet"], "gaps_m": [0.1, 0.2]}},
            "push_mps2 has the shape",
        ),
        ({"wind": [1]}, "air: wind = .*; must be a mapping with .*"),
    ],
)
def test_a_wrong_entry_is_named(change: dict[str, object], message: str) -> None:
    with pytest.raises(AirError, match=message):
        decode(_rechecksummed(change))


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "room.air"
    path.write_text('{"format": "q2q-model"}')
    with pytest.raises(AirError, match=r'air file .*: not a q2q air: entry "format" should be "q2q-air"'):
        load(path)


def test_every_name_gives_an_air() -> None:
    assert [find_air(name) for name in LAWS] == list(WakeLaw)
    for name in SYNTHETIC:
        found = find_air(name)
        assert isinstance(found, RoomAir)
        assert found.jet is not None
        # the largest push of the measured law at 0.4 m
        assert found.jet.push_mps2[6].max() == pytest.approx(2.5, rel=1e-9)
        assert found.jet.gaps_m[6] == pytest.approx(0.4)


def test_a_path_gives_the_air_of_its_file_without_some_terms(tmp_path: Path) -> None:
    path = tmp_path / "mine.air"
    save(path, WHOLE)
    found = find_air(str(path), ("wind", "jet"))
    assert isinstance(found, RoomAir)
    assert encode(found) == encode(without_terms(WHOLE, ("wind", "jet")))
    assert found.wind is found.jet is None


def test_unknown_airs_and_terms_are_refused_with_the_known_ones() -> None:
    with pytest.raises(AirError, match=r"no air 'storm': give one of none, paper, measured, ring"):
        check_air("storm")
    with pytest.raises(AirError, match="unknown term 'rain' of an air; choose one of jet, absorption"):
        find_air("bent", ("rain",))
    with pytest.raises(AirError, match=r"air measured has no terms to switch off \(jet\)"):
        find_air("measured", ("jet",))


@pytest.mark.parametrize(
    ("term", "change", "message"),
    [
        ("wind", {"mean_mps2": (np.nan, 0.0, 0.0)}, "wind.mean_mps2 has nan; must be finite"),
        ("wind", {"gust_time_s": 0.0}, "wind.gust_time_s has 0.0; must be finite and above 0"),
        ("wind", {"gust_std_mps2": -0.1}, "wind.gust_std_mps2 has -0.1; must be finite and at least 0"),
        ("residual", {"time_s": 0.0}, "residual.time_s has 0.0; must be finite and above 0"),
        (
            "jet",
            {"push_mps2": 1e3 * WHOLE.jet.push_mps2},
            "jet.push_mps2 has .*, at most 49.1 in magnitude",
        ),
        (
            "wind",
            {"gust_std_mps2": 50.0},
            "wind.gust_std_mps2 has 50.0; must be finite and at least 0, at most 49.1 in magnitude",
        ),
        ("jet", {"push_mps2": np.nan * WHOLE.jet.push_mps2}, "jet.push_mps2 has nan; must be finite"),
        ("vehicle", {"thrust_lag_s": np.nan}, "vehicle.thrust_lag_s has nan; must be finite and at least 0"),
    ],
)
def test_a_number_that_no_air_has_is_refused(term: str, change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        replace(WHOLE, **{term: replace(getattr(WHOLE, term), **change)})


def test_an_air_that_no_flight_gives_is_read_if_vehicles_could_fly_in_it() -> None:
    """learn_air gives no push above g and no share above 1; older files and those made by hand have some."""
    strong = WHOLE.jet.push_mps2 * (1.5 * GRAVITY / WHOLE.jet.push_mps2.max())
    air = RoomAir(replace(WHOLE.jet, push_mps2=strong, upper_ratio=1.5), replace(WHOLE.absorption, share=1.2))
    assert encode(decode(encode(air))) == encode(air)


def test_every_bound_is_of_a_field_of_a_term() -> None:
    known = {one.name for name in TERMS for one in fields(getattr(WHOLE, name))}
    assert {*ABOVE_ZERO, *NOT_NEGATIVE, *ACCELERATIONS} <= known
