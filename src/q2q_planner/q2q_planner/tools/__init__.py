"""Command-line tools of q2q_planner: parse, read files, call the library, print, draw."""
