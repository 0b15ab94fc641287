"""Parameters as dataclass fields with bounds."""

import pickle
from dataclasses import dataclass

import numpy as np
import pytest

from q2q_model.nearest_name import parameter_hint
from q2q_model.tunable import OutOfBoundsError, check_bounds, tunable, with_overrides


@dataclass(frozen=True, slots=True)
class Demo:
    """Three parameters."""

    gain: float = tunable(1.0, "a gain", unit="1/s", low=0.0, high=2.0)
    mode: str = tunable("a", "a choice", choices=("a", "b"))
    vehicles: tuple[str, ...] = tunable((), "names")

    def __post_init__(self) -> None:
        """Check."""
        check_bounds(self)


def test_an_override_replaces_one_field_and_keeps_the_rest() -> None:
    assert with_overrides(Demo(), {"gain": 1.5}) == Demo(gain=1.5, mode="a")


@pytest.mark.parametrize("wrong", [-0.1, 2.1, float("nan"), float("inf")])
def test_a_value_out_of_bounds_is_refused_naming_value_and_bounds(wrong: float) -> None:
    with pytest.raises(ValueError, match=r"Demo.gain = .*; must be in \[0.0, 2.0\] 1/s"):
        Demo(gain=wrong)


@pytest.mark.parametrize("wrong", ["1", True, None, np.array(1.0), (1.0,)])
def test_what_is_no_number_is_refused_where_one_is_expected(wrong: object) -> None:
    with pytest.raises(ValueError, match=r"Demo\.gain = .*; must be a number in \[0\.0, 2\.0\] 1/s"):
        Demo(gain=wrong)
    assert Demo(gain=np.float32(1.0)) == Demo(gain=1) == Demo(gain=np.int64(1)) == Demo()


def test_an_unknown_key_is_answered_with_the_nearest_right_one() -> None:
    with pytest.raises(ValueError, match="did you mean gain"):
        with_overrides(Demo(), {"gian": 1.0})


def test_a_wrong_choice_is_refused_with_the_right_ones() -> None:
    with pytest.raises(ValueError, match=r"Demo\.mode = 'c'; must be one of a, b"):
        Demo(mode="c")


@pytest.mark.parametrize("empty", ["", " ", "\t"])
def test_a_list_of_names_has_none_that_is_empty_or_of_spaces_only(empty: str) -> None:
    assert Demo(vehicles=("cf1", "cf 2")).vehicles == ("cf1", "cf 2")
    with pytest.raises(ValueError, match=r"Demo.vehicles = .*; texts must not be empty: leave out"):
        Demo(vehicles=("cf1", empty))


def test_an_error_comes_whole_from_another_process() -> None:
    with pytest.raises(OutOfBoundsError) as raised:
        Demo(gain=3.0)
    copy = pickle.loads(pickle.dumps(raised.value))  # noqa: S301 - made on the line itself
    assert (copy.name, str(copy)) == ("gain", "Demo.gain = 3.0; must be in [0.0, 2.0] 1/s")


@pytest.mark.parametrize(
    ("given", "known", "hint"),
    [
        ("land_s", ["land_share", "land_after_s"], "it is now land_after_s"),
        ("land_s", ["land_speed", "landing_duration_min"], "it is now landing_duration_min"),
        ("mode", ["model", "axes"], "it is now axes"),
        ("mode", ["model", "gain"], "did you mean model?"),
    ],
)
def test_a_renamed_parameter_is_answered_with_its_present_name(
    given: str, known: list[str], hint: str
) -> None:
    """The nearest ones by their letters bound other things: by 1 of land_share a vehicle would not land."""
    assert parameter_hint(given, known) == hint
