"""Faults of a room, and their injection into frames, packets and rotors."""
