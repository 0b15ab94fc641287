"""Real vehicles over cflib: links, procedure of each vehicle, and the vehicles of the node `radio`."""
