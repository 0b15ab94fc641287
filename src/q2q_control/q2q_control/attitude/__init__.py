"""Thrust and attitude of a demanded acceleration, limits of commands, attitude loop, rotor allocation."""
