"""Content of a node's `/diagnostics`, without ROS: health, values, durations."""
