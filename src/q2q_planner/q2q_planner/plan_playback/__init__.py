"""Playback of plans: start, glide, brake and hold, tick by tick."""
