"""The room `real` disturbs a hovering Crazyflie as much as real rooms do."""

from dataclasses import replace

import numpy as np

from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.scenarios import library


def test_clear_air_shows_the_real_flights_altitude_error() -> None:
    base = library.load("stack3")
    spots = [
        (3.0 * (i % 6), 3.0 * (i // 6), 1.0) for i in range(24)
    ]  # far apart: no downwash, 24 samples at once
    hover = tuple(
        VehicleWaypoints(f"cf{i + 1}", (Waypoint(0.0, spot), Waypoint(30.0, spot)))
        for i, spot in enumerate(spots)
    )
    scenario = replace(base, wake="none", model="none", duration=30.0, waypoints=hover)
    flight = fly(scenario, FlightOptions(mode="ignoring", seed=0))
    error = (flight.true_pos - flight.ref_pos)[500:, :, 2]  # settled after 5 s
    # 1.87 cm; 24 vehicles' thrust offsets, even over 0.08 to 0.27 m/s^2, leave 1.1 mm of standard error
    assert abs(float(np.sqrt(np.mean(error**2))) - 0.0187) < 0.0025
    wander = error - error.mean(axis=0)
    assert 0.005 < float(wander.std()) < 0.010  # what the vehicles of those flights span
