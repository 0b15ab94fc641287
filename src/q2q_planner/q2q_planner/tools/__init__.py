"""Work of the command-line tools of q2q_planner: read files, call the library, print, draw."""
