"""Stopping motions within bounds on acceleration and jerk, and the approach speeds that they allow."""
