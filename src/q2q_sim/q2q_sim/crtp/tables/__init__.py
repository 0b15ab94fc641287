"""Tables of contents of parameters and log variables."""
