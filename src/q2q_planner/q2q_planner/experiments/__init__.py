"""Random encounters under the safe replanner, for tests and benchmarks."""
