"""CRTP packets and their fields."""
