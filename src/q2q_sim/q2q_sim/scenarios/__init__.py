"""Scenarios: vehicles, their waypoints, sensors and air. The YAML files here are the shipped ones."""
