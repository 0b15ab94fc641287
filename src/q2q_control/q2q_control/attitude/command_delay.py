"""Delay of a command on the way to the rotors."""

LATENCY_S = 0.026
"""Time from a tick's stamp to its command's effect [s]: camera (10 ms) and radio (16) of the room `real`."""
