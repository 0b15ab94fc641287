"""The simulation loop: room, blocks of a flight, closed loop without ROS, recorder."""
