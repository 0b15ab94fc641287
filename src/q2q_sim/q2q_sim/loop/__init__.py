"""The simulation loop: room, blocks, closed loop, lockstep gate, recording."""
