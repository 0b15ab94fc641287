"""Work of the command-line tools of q2q_control: read files, call the library, print, draw."""
