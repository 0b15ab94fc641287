"""Mixer, motors, battery and airframe."""
