"""ROS 2 nodes of q2q_sim: convert messages, call pure code, publish."""
