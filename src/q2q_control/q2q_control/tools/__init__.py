"""Command-line tools of q2q_control: parse, read files, call the library, print, draw."""
