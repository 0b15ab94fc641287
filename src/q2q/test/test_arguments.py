"""Arguments of the public functions: mistakes are refused with what was given and what is allowed."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hovering_stack import STACK

import q2q
from q2q_sim.air.air_names import shipped_airs

BAG = Path(__file__).parents[3] / "bags" / "table2_1"
AIR = r"; must be a shipped name, the path of a .air file or module:Class$"
BEYOND = r"; must be a finite number above 0 m/s\^2$"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: q2q.fly(STACK, aware="no"), r"aware = 'no'; must be True or False$"),
        (lambda: q2q.fly(STACK, limit=0), r"limit = 0; must be True or False$"),
        (lambda: q2q.fly(STACK, correct="no"), r"correct = 'no'; must be True or False$"),
        (lambda: q2q.fly(STACK, seed=1.5), r"seed = 1.5; must be an integer >= 0$"),
        (lambda: q2q.fly(STACK, seed="1"), r"seed = '1'; must be an integer >= 0$"),
        (lambda: q2q.fly(STACK, air=3), r"no air 3: give a name as for q2q.scenario, an air of q2q.load_air"),
        (lambda: q2q.fly(STACK, air=None), r"no air None: give a name"),
        (lambda: q2q.load_air(None), f"air = None{AIR}"),
        (lambda: q2q.scenario(STACK, air=3), f"air = 3{AIR}"),
        (lambda: q2q.campaign(1, air=3), f"air = 3{AIR}"),
        (lambda: q2q.load_air(q2q.load_air("room")), rf"air = RoomAir\(.{{,30}}{AIR}"),  # not all its table
        (
            lambda: q2q.load_air("room", without="residual"),
            r"without = 'residual'; must be a tuple of terms, like",
        ),
        (
            lambda: q2q.scenario(None),
            r"scenario = None; must be a name, a file, a document or a q2q.Scenario",
        ),
        (lambda: q2q.identify(bytes(BAG)), r"bags = b'.*table2_1'; must be text or a Path, not bytes$"),
        (lambda: replace(q2q.scenario(STACK), duration="3"), r"duration = '3'; must be a number of seconds$"),
        (lambda: q2q.identify(BAG, threshold="x"), f"threshold = 'x'{BEYOND}"),
        (lambda: q2q.identify(3), r"bags = 3; must be the folder of a bag, or several$"),
        (lambda: q2q.campaign(2.5), r"runs = 2.5; must be an integer >= 1$"),
        (lambda: q2q.campaign(1, out=None), r"out = None; must be the path of a folder$"),
        (lambda: q2q.campaign(runs=True), r"runs = True; must be an integer >= 1$"),
    ],
)
def test_an_argument_of_another_type_is_refused_with_one_sentence(call: Callable[[], object], message: str):
    with pytest.raises(TypeError, match=f"^{message}"):
        call()


@pytest.mark.parametrize("threshold", [np.nan, np.inf, 0.0, -0.1])
def test_a_zone_that_no_model_has_is_refused_before_the_bags_are_read(threshold: float):
    with pytest.raises(ValueError, match=rf"^threshold = {threshold}{BEYOND}"):
        q2q.identify("absent", threshold=threshold)


def test_an_unknown_air_ends_a_campaign_before_its_runs():
    with pytest.raises(ValueError, match="no air 'rome'"):
        q2q.campaign(1, air="rome")


@pytest.mark.parametrize(("name", "why"), [("file", "give a folder"), ("file/below", "it cannot hold below")])
def test_a_folder_that_cannot_be_written_to_ends_a_campaign_before_its_runs(
    tmp_path: Path, name: str, why: str
):
    """Else the first violation would: by its error, or with several jobs as a crash of the run."""
    (tmp_path / "file").touch()
    with pytest.raises(ValueError, match=f"^out: .*/file is a file; {why}$"):
        q2q.campaign(1, out=tmp_path / name)


def test_flags_and_seeds_of_numpy_are_flags_and_seeds():
    plain = q2q.fly(STACK, aware=False, seed=3)
    given = q2q.fly(STACK, aware=np.False_, seed=np.int64(3))
    np.testing.assert_array_equal(given.arrays.true_pos, plain.arrays.true_pos)
    assert given.facts == plain.facts


def test_an_air_is_found_by_its_path(tmp_path: Path):
    copy = tmp_path / "copy.air"
    copy.write_bytes((shipped_airs() / "room.air").read_bytes())
    assert q2q.scenario(STACK, air=copy).air == str(copy)
    by_path, by_name = q2q.fly(STACK, air=copy), q2q.fly(STACK, air="room")
    np.testing.assert_array_equal(by_path.arrays.true_pos, by_name.arrays.true_pos)
    assert by_path.facts.air == str(copy)
