"""Recorded flights replayed through estimators from the command line."""

import sys
from argparse import Namespace
from collections.abc import Sequence

from q2q_model.documents.json_file import write_json
from q2q_model.recordings.flight_recording import Recording
from q2q_sim.experiments.estimators.estimate_errors import ReplayedErrors, replayed_errors
from q2q_sim.experiments.estimators.estimator_table import (
    error_table,
    errors_json,
    flight_table_of,
    print_whole,
)
from q2q_sim.experiments.estimators.recorded_motion import RecordedMotion, recorded_motion


def replay_flights(recordings: Sequence[Recording], args: Namespace) -> int:
    """Replay, print and write the errors; return the exit status."""
    found: list[ReplayedErrors] = []
    for one in recordings:
        motion = _motion(one)
        if motion is not None:
            print(f"estimators: {motion.name} ...", file=sys.stderr, flush=True)
            found += replayed_errors(motion, range(args.draws))
    if not found:
        raise ValueError("none of these flights can be replayed")
    if args.json:
        write_json(errors_json(found, args.draws), args.json)
    for table in [error_table(found), *([flight_table_of(found)] if args.each else [])]:
        print_whole(table)
    return 0


def _motion(recording: Recording) -> RecordedMotion | None:
    """Return the motion of a recording; None, and a note, for one that cannot be replayed."""
    try:
        return recorded_motion(recording)
    except ValueError as refusal:
        print(f"estimators: skipped: {refusal}", file=sys.stderr)
        return None
