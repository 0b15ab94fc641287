"""Launch files: which nodes each starts, and its arguments."""
