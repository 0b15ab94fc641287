"""Vehicle constants with their sources, setpoint watchdog, altitude loop, thrust map."""
