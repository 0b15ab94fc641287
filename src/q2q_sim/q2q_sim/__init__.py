"""A stand-in for the room: vehicles, wake, radio, VICON, scenarios, flights, reports."""
