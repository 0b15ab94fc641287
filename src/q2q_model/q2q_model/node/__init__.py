"""Node services without ROS: health, warm-up, stopwatch, wiring."""
