"""Scenarios: who flies where, in which room and air. The YAML files here are the shipped ones."""
