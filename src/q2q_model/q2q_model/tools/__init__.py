"""Work of the command-line tools: read files, identify or score, print and plot."""
