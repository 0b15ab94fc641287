"""Simulation of vehicles, wake, radio and VICON; scenarios, flights, campaigns, reports."""
