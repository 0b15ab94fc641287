"""Where to fly: trajectories, minimum snap, zone avoidance, the online replanner."""
