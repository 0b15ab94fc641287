"""What a node reports of itself on `/diagnostics`, without ROS: health, values, laps."""
