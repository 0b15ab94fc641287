"""Onboard attitude loop and rotor allocation."""
