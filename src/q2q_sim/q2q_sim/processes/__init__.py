"""Node processes: start, warm start, cores, ROS domain, interruption."""
