"""Real vehicles over cflib: links, setpoints, pilot, parameters."""
