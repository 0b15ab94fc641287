"""ROS 2 nodes of q2q_planner: convert, call the library, publish."""
