"""Tables and figures of the paper, reproduced with the project's own flights."""
