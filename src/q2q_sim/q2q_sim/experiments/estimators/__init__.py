"""Recorded flights replayed through estimators: the mocap filter and the firmware's, with poses withheld."""
