"""Content of the documentation: figures, the animation and the pages of the nodes."""
