"""Random encounters and swaps in a crowded room, for tests and benchmarks."""
