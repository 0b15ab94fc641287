"""ROS 2 nodes of q2q_model: convert, call the library, publish."""
