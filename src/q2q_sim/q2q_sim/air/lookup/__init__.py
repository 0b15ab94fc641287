"""Airs by their names: shipped, recorded, of a file or of a class; and how fast their downwash travels."""
