"""Settings of every test: hypothesis fails none for being slow, as speeds are measured in benchmarks."""

import os

from hypothesis import settings

pytest_plugins = ["budgets", "changed", "two_hosts"]

settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.pop("ROS_DOMAIN_ID", None)  # workers would meet in it: each test takes a free one
