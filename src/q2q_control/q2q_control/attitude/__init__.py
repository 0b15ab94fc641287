"""Thrust and attitude of a demanded acceleration, onboard attitude loop, rotor allocation."""
