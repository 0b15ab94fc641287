"""Settings of every test: hypothesis fails none for being slow, as speeds are measured in benchmarks."""

from hypothesis import settings

pytest_plugins = ["budgets", "changed"]

settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")
