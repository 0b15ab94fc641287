"""Tables and figures of the paper, remade from the project's own flights."""
