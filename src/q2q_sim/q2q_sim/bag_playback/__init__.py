"""Playback of a bag: its schedule, the messages played, the ticks they answer, the wait for subscribers."""
