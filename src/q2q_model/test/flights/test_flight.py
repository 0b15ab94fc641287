"""The flight of one vehicle out of a swarm's."""

from dataclasses import fields

import numpy as np
from made_flights import Pass, made_flight

from q2q_model.flights.flight import of_vehicle


def test_the_flight_of_one_vehicle_has_its_columns_of_every_array() -> None:
    whole = made_flight(Pass())
    one = of_vehicle(whole, whole.names[1])
    assert one.names == whole.names[1:2]
    for field in fields(whole):
        of_all = getattr(whole, field.name)
        if isinstance(of_all, np.ndarray) and field.name != "t":
            np.testing.assert_array_equal(getattr(one, field.name), of_all[:, 1:2])
    np.testing.assert_array_equal(one.t, whole.t)
