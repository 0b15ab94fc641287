"""Explanation of a simulated flight: which cause took a vehicle off its path, and by how much.

bag -> FlightSetup -> flights with causes removed -> contributions to the deviation -> sentence, page, JSON
"""
