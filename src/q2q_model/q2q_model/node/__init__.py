"""Node services without ROS: warm-up, readiness, restriction to this machine."""
