"""Hold the memory of the mocap filter: tracks of positions and attitudes that survive bad samples."""
