"""Real vehicles over cflib: their link, their pilot, and the vehicles of the node `radio`."""
