"""CRTP packets, their fields, and the radio link that carries them."""
