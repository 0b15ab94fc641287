"""Limits of a command, and its delay on the way to the rotors."""

LATENCY_S = 0.026
"""Time from a tick's stamp to its command's effect [s]: camera (10 ms) and radio (16) of the room `real`."""

THRUST_LEAST = 0.05
"""Minimum thrust over weight of a controller's command [-]: with none, or less than MIN_THRUST, 1000 of 65535
(2 to 3 % of the weight), a Crazyflie's motors stop, and nothing holds its attitude."""
