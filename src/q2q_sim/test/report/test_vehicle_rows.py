"""Tables of flights: every vehicle up to ten, then median and extremes; three significant digits."""

import math

import pytest

from q2q_sim.report.significant_digits import centimetres, significant_digits
from q2q_sim.report.vehicle_rows import drawn_vehicles_note, plotted_vehicles, vehicle_rows


def test_ten_vehicles_have_a_row_each() -> None:
    numbers = {f"cf{k}": (float(k), 2.0) for k in range(10)}
    assert vehicle_rows(numbers) == [(name, list(row)) for name, row in numbers.items()]


def test_more_vehicles_are_summarised_by_median_and_extremes_of_what_is_known() -> None:
    numbers = {f"cf{k}": (float(k), math.nan) for k in range(11)} | {"cf0": (math.nan, 7.0)}
    assert vehicle_rows(numbers) == [
        ("median", [5.5, 7.0]),
        ("smallest", [1.0, 7.0]),
        ("largest", [10.0, 7.0]),
        ("vehicles", [10, 1]),
    ]


def test_of_many_vehicles_the_worst_are_drawn_and_the_page_says_so() -> None:
    assert drawn_vehicles_note(20, "a") == [
        "Drawn are the 4 of 20 vehicles with the largest z RMSE in flight a."
    ]
    assert drawn_vehicles_note(10, "a") == []
    errors = {f"cf{k}": 0.1 * k for k in range(20)} | {"cf7": 9.0, "cf19": math.nan}
    assert plotted_vehicles(errors) == ["cf7", "cf18", "cf17", "cf16"]
    assert plotted_vehicles({"cf2": 0.0, "cf1": 1.0}) == ["cf2", "cf1"]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.13093, "0.131"),
        (2055.06, "2060"),
        (-6.92, "-6.92"),
        (99.96, "100"),
        (6.6, "6.60"),
        (0.00029, "0.0003"),
        (-0.00001, "0"),
        (0.0, "0"),
        (6, "6"),
        (float("nan"), "-"),
        (float("inf"), "-"),
        (None, "-"),
    ],
)
def test_numbers_have_three_significant_digits_and_no_exponent(value: float | None, text: str) -> None:
    assert significant_digits(value) == text


def test_lengths_are_told_in_centimetres() -> None:
    assert (centimetres(0.34244), centimetres(0.10925), centimetres(0.00614)) == ("34 cm", "11 cm", "0.61 cm")
