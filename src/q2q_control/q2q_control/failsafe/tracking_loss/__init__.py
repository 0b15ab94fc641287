"""Motion, by their commands, of vehicles without measurements, and how they brake."""
