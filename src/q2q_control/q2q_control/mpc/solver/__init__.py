"""Solvers of the linear-quadratic problem with bounded inputs."""
