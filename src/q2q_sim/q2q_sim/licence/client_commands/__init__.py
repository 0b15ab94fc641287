"""Commands of a program to its vehicles, in words, and plans beyond the vehicles' limits."""
