"""A short flight for tests: two vehicles that hover above each other, 0.5 m apart."""

STACK = {
    "vehicle": "crazyflie_2_0",
    "duration": 0.1,
    "vehicles": {
        "cf1": [{"t": 0.0, "pos": [0.0, 0.0, 1.0]}, {"t": 2.0, "pos": [0.0, 0.0, 1.0]}],
        "cf2": [{"t": 0.0, "pos": [0.0, 0.0, 1.5]}, {"t": 2.0, "pos": [0.0, 0.0, 1.5]}],
    },
}
