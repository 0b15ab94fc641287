"""Trace of a flight in a bag, by which the safety policies judge it."""

import warnings
from pathlib import Path

from q2q_model.bag import BagReader, BagRepairWarning
from q2q_model.bag.flight_in_bag import topics_by_name
from q2q_model.signals.stamps import time_from_stamp
from q2q_sim.monitors.policies import FlightTrace, RecordedSignal, trace_of


def trace_in(bag: Path) -> FlightTrace:
    """Return the trace in a bag, with a BagRepairWarning if messages may be missing.

    Raises:
        ValueError: the bag cannot be read or has no flight.
    """
    reader = BagReader(bag)
    for repair in reader.repairs:
        warnings.warn(repair, BagRepairWarning, stacklevel=2)
    names = topics_by_name(reader)
    return trace_of(
        RecordedSignal(names[one.topic], time_from_stamp(one.stamp_ns), one.signal)
        for one in reader.signals(names)
    )
