"""Joint avoidance (18): sequential convexification with separating planes."""
