"""Vertical downwash measured in flight, and checks of the sensors and logs that it is measured by."""
