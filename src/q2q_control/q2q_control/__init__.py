"""How to push: interaction-aware PID and MPC."""
