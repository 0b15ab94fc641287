"""Solver of one tick's horizon: groups of vehicles, and the linear-quadratic problem with bounded inputs."""
