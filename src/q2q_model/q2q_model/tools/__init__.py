"""Command-line tools of q2q_model: parse, read files, call the pure floor, print, draw."""
