"""Settings of every test: hypothesis never fails one for being slow, as speeds are measured in benchmarks/."""

from hypothesis import settings

settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")
