"""Node services without ROS: health, rehearsal, stopwatch, wiring."""
