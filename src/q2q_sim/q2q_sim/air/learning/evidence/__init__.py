"""What recorded flights tell about their air, and intervals of what is learned from it."""
