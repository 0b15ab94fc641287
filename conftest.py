"""Settings of every test: hypothesis fails none for being slow, as speeds are measured in benchmarks.

Programs are interrupted as in a foreground shell, also where the tests run in the background of one, in which
they would inherit that SIGINT is ignored.
"""

import os
import signal

from hypothesis import settings

pytest_plugins = ["budgets", "changed", "two_hosts"]

signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.pop("ROS_DOMAIN_ID", None)  # workers would meet in it: each test takes a free one
