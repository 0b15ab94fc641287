"""Topics that a flight's bag records, their playback, and the recorded metadata."""
