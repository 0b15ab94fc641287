"""Command-line tools of q2q_sim: parse, read files, call the pure floor, print, draw."""
