"""Crazyswarm2: configuration file and message conversion."""
