"""Laws of stopping: how a motion comes to rest within bounds, and how fast it may approach where it must."""
