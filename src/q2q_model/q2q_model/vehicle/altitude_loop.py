"""Closed altitude loop that models an unknown onboard controller: (13), (14).

    z'' = z_ref'' + K_d (z_ref' - z') + K_p (z_ref - z) + K_i integral(z_ref - z) + b + eta

The paper has K_p and K_d only. Thrust follows its command with a first-order lag.

| symbol | name | meaning [unit] |
|---|---|---|
| K_p K_d K_i | k_p k_d k_i | gains [1/s^2], [1/s], [1/s^3] |
| b | offset | constant acceleration, e.g. from a mass or battery error [m/s^2] |
| | lag | time constant [s] |
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class AltitudeLoop:
    """Gains of one vehicle's closed altitude loop."""

    k_p: float
    k_d: float
    k_i: float = 0.0
    offset: float = 0.0
    lag: float = 0.0


PAPER_LOOP = AltitudeLoop(k_p=0.81073, k_d=0.42952)
"""Gains in the caption of Fig. 5."""
