"""Verdict on the flight in a bag, with what the bag says of its end."""

from pathlib import Path

from q2q_model.bag import BagReader, read_facts
from q2q_model.flights.flight import Flight
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.flight_bag.scenario_facts import flown_faults
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.flight_verdict import FlightVerdict
from q2q_sim.monitors.policies import Circumstances
from q2q_sim.monitors.recording_end import with_end


def bag_verdict(bag: Path, flight: Flight, vehicle: Vehicle) -> FlightVerdict:
    """Return the verdict on a flight of `vehicle`s up to the end of its bag."""
    verdict = verdict_of(flight, Circumstances(vehicle=vehicle, faults=flown_faults(bag)))
    return with_end(verdict, flight, read_facts(bag).duration, is_cut=BagReader(bag).is_cut)
