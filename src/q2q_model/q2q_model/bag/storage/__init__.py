"""Bag storage: channels and bytes of MCAP, sqlite3 and ROS 1 files, including damaged ones."""
