"""One vehicle: its state, its rotors and its rigid body, step by step."""
