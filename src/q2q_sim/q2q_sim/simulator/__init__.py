"""The simulator behind its node: flight of a room through nodes, its pace, outputs and timing."""
