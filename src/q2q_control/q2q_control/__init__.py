"""PID and MPC that compensate downwash, failsafe, flight procedure, interfaces to Crazyflies."""
