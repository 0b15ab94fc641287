"""Simulation of vehicles, downwash, radio and motion capture; scenarios, flights, campaigns, reports."""
