"""Injected faults: in motion capture frames, packets and rotors."""
