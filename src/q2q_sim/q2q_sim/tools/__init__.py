"""Work of the command-line tools of q2q_sim: read files, call the library, print, draw."""
