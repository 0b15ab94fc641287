"""Position tracks: motion model, gates, steps, and the association of samples."""
