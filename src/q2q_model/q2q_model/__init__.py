"""What the world is: signals, vehicles, mocap filter, interaction models, identification."""
