"""Playback of plans: start, transit, brake and hold, tick by tick."""
