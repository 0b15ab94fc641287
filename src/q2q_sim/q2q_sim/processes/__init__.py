"""Node processes: start, preloaded forks, cores, ROS domain, interruption."""
