"""Explanation of a simulated flight: which cause took a vehicle off its path, and by how much.

bag -> FlightSetup -> flights with causes taken out -> shares of the loss -> sentence, page, JSON
"""
