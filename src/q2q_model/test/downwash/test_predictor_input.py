"""What is no state, no model or no relative position is refused with what is needed instead."""

import re
from dataclasses import replace

import numpy as np
import pytest
from resting_signals import resting_state

from q2q_model.downwash.interaction_model import downwash_at_rest
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.downwash.predictor import InteractionPredictor
from q2q_model.model_files.model_file import ModelFile

STATE = resting_state(
    0.0, ("cf1", "cf2", "cf3"), np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5], [0.0, 0.0, 2.1]])
)


@pytest.mark.parametrize("name", ["pos", "vel", "quat", "age", "status"])
def test_an_array_that_lacks_a_row_is_named(name: str) -> None:
    """Compiled code reads and writes by the number of names: a row too few would be beyond an array."""
    right = getattr(STATE, name)
    needed = re.escape(
        f"{name} of a state of 3 names is of shape {right[:1].shape}; must be an array {right.shape}"
    )
    with pytest.raises(ValueError, match=needed):
        InteractionPredictor(PAPER_LAW).update(replace(STATE, **{name: right[:1]}))


@pytest.mark.parametrize("name", ["pos", "age", "status"])
def test_a_list_is_no_array(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} of a state of 3 names is a list; must be an array"):
        InteractionPredictor(PAPER_LAW).update(replace(STATE, **{name: getattr(STATE, name).tolist()}))


def test_names_of_another_number_than_the_rows_are_refused() -> None:
    with pytest.raises(ValueError, match=r"pos of a state of 2 names is of shape \(3, 3\)"):
        InteractionPredictor(PAPER_LAW).update(replace(STATE, names=("cf1", "cf2")))


def test_a_name_or_a_model_file_is_no_interaction_model() -> None:
    with pytest.raises(TypeError, match="a str is given; must be an InteractionModel"):
        InteractionPredictor("measured_law")
    with pytest.raises(TypeError, match=r"a ModelFile is given; .*`interaction` of a ModelFile"):
        InteractionPredictor(ModelFile(PAPER_LAW))


def test_relative_positions_may_be_lists_and_have_three_coordinates() -> None:
    at = [[0.0, 0.0, 0.5], [0.0, 0.0, -0.5]]
    np.testing.assert_array_equal(downwash_at_rest(PAPER_LAW, at), downwash_at_rest(PAPER_LAW, np.array(at)))
    with pytest.raises(ValueError, match=r"rel_pos of shape \(3, 5\) is given; must be \(\.\.\., 3\)"):
        downwash_at_rest(PAPER_LAW, np.zeros((3, 5)))
