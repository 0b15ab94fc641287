"""Interaction-aware PID and MPC, failsafe, interfaces to Crazyflies."""
