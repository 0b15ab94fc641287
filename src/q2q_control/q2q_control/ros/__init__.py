"""ROS 2 nodes of q2q_control: convert, call the library, publish."""
