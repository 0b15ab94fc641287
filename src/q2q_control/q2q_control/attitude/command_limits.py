"""Limits of a command, its delay on the way to the rotors, and how long it holds without a newer one."""

from q2q_model.signals.clock_resets import PATIENCE_S

LATENCY_S = 0.026
"""Time from a tick's stamp to its command's effect [s]: camera (10 ms) and radio (16) of the room `real`."""

LONGEST_HOLD_S = PATIENCE_S
"""Time for which a vehicle's last command is repeated before it levels [s], unless set otherwise: until old
stamps are known to be of a clock that was set back."""

THRUST_LEAST = 0.05
"""Minimum thrust over weight of a controller's command [-]: with none, or less than MIN_THRUST, 1000 of 65535
(2 to 3 % of the weight), a Crazyflie's motors stop, and nothing holds its attitude."""
