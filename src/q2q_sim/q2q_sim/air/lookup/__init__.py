"""Air models by name: shipped, recorded, from a file or a class, and the travel speed of their downwash."""
