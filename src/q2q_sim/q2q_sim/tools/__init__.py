"""Command-line tools of q2q_sim: read files, call pure code, print, draw."""
