"""ROS 2 nodes of q2q_sim: convert, call the floor below, publish."""
