"""Result of a flight, simulated or recorded: arrays, metrics and verdict; figures, bag and page."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import yaml
from matplotlib.figure import Figure

from q2q.bag_scenario import FILE, bag_document
from q2q_model.bag import BagError, BagReader, BagWriter, FlightFacts, read_facts
from q2q_model.documents.written_file import write_text
from q2q_model.flights.flight import Flight
from q2q_model.flights.tables.table_file import TABLES
from q2q_model.flights.units_and_frames.frame_notes import frame_notes
from q2q_model.recordings.bag_vehicle import FlownVehicle, flown_vehicle
from q2q_model.recordings.filtered_states import with_filtered_states
from q2q_model.recordings.recording_reader import flight_of_bag, recording_of_table
from q2q_model.recordings.recordings_of_bags import topic_map
from q2q_model.signals.stamps import stamp_from_time
from q2q_model.vehicle.constants import Vehicle
from q2q_sim.faults.faults import Fault
from q2q_sim.flight_bag.scenario_facts import flown_faults
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.flight_verdict import FlightVerdict
from q2q_sim.monitors.metrics.flight_metrics import FlightMetrics, measure
from q2q_sim.monitors.policies import Circumstances, RecordedSignal
from q2q_sim.monitors.recording_end import with_end
from q2q_sim.replay_page import in_air, replay_html, replay_run
from q2q_sim.report.figures import KINDS, PlotCurve, plot_quantity
from q2q_sim.scenarios.choices import CONTROLLERS
from q2q_sim.scenarios.scenario import Scenario

NAMED = 4
"""Most vehicles that a printed result names; of more it gives the number."""
FigureKind = Literal["altitude", "sideways", "downwash", "thrust", "tilt"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FlightResult:
    """Result of a flight of T ticks and n vehicles."""

    arrays: Flight
    """Signals over time, one row per tick: SI, world frame z up, (T, n, ...); NaN where not recorded."""
    vehicle: Vehicle
    """Vehicle type of the swarm."""
    facts: FlightFacts = field(default_factory=FlightFacts)
    """Scenario, mode, controller, model, air and seed."""
    faults: tuple[Fault, ...] = ()
    """Faults injected by the scenario."""
    signals: tuple[RecordedSignal, ...] = ()
    """Messages of a simulated flight, as its nodes would publish them."""
    scenario: Scenario | None = None
    """Scenario of a simulated flight."""
    is_cut: bool = False
    """Whether the bag that it was read from was cut off, so that its end is unknown."""

    def __repr__(self) -> str:
        """Return what flew, and the verdict, in one line."""
        facts, many = self.facts, len(self.names) > NAMED
        seed = f"seed {facts.seed}" if facts.seed else ""
        how = filter(None, (facts.scenario or self.arrays.name, _shown(facts.controller), facts.mode, seed))
        who = f"{len(self.names)} vehicles" if many else ", ".join(self.names)
        return f"<FlightResult {', '.join(how)}: {who}; {self.verdict}>"

    @property
    def names(self) -> tuple[str, ...]:
        """Return the vehicles' names, in the order of the arrays' second axis."""
        return self.arrays.names

    @property
    def metrics(self) -> FlightMetrics:
        """Return RMS errors [m], thrust [N] and separation [m]; of the true positions where known."""
        return measure(self.arrays, self.vehicle)

    @property
    def verdict(self) -> FlightVerdict:
        """Return whether the flight went well, and what did not; `str` gives one line."""
        verdict = verdict_of(self.arrays, Circumstances(vehicle=self.vehicle, faults=self.faults))
        return with_end(verdict, self.arrays, self.facts.duration, is_cut=self.is_cut)

    def plot(self, kind: FigureKind = "altitude", vehicle: str = "") -> Figure:
        """Return a figure of one vehicle over time; see `q2q.plot`."""
        return plot({self.arrays.name: self}, kind, vehicle)

    def to_bag(self, path: Path | str) -> Path:
        """Write the flight as a rosbag2 folder (MCAP) with the nodes' topics; return its path.

        A scenario that its name does not give, as of a document, is written into the folder: scenario.yaml;
        what that cannot hold, a plan or a vehicle of no name, is a warning.

        Raises:
            BagError: the path exists, or the flight was itself read from a bag.
        """
        if not self.signals:
            raise BagError(f"{self.arrays.name} was read from a bag: copy that")
        document = None if self.scenario is None else bag_document(self.scenario, self.facts)
        facts = self.facts if document is None else replace(self.facts, scenario=FILE)
        with BagWriter(path, facts=facts) as writer:
            for one in self.signals:
                writer.write_signal(f"/{one.topic}", stamp_from_time(one.at), one.signal)
        if document is not None:
            write_text(yaml.safe_dump(document, sort_keys=False), writer.path / FILE)
        return writer.path

    def page(self, path: Path | str) -> Path:
        """Write a page that replays the flight in a browser, offline (.html); return its path."""
        return page({self.arrays.name: self}, path)


def read_bag(path: Path | str, vehicle: str = "", *, topics: Path | str | None = None) -> FlightResult:
    """Return a recorded flight, with filtered states where none are recorded.

    A vehicle that had to be assumed, and a frame that seems to be wrong, are warnings.

    Args:
        path: folder of a rosbag2 bag, or its .mcap file; or a table (.parquet, .csv).
        vehicle: name of the vehicle; empty takes that of the bag's metadata, else the default.
        topics: topic map (YAML) of a bag of other software; None for a bag of q2q.

    Raises:
        BagError: the bag cannot be read.
        ValueError: there is no such vehicle, the table cannot be read, or is given with a topic map, or
            positions are not in metres.
    """
    given, flown = Path(path), flown_vehicle(Path(path), vehicle)
    if given.suffix in TABLES and topics:
        raise ValueError(f"topics applies to bags, but {given} is a table: leave out topics")
    if given.suffix in TABLES:
        return _read(recording_of_table(given).flight, flown)
    flight = with_filtered_states(flight_of_bag(given, topic_map(Path(topics) if topics else None)))
    facts, faults = read_facts(given), flown_faults(given)
    return replace(_read(flight, flown), facts=facts, faults=faults, is_cut=BagReader(given).is_cut)


def _read(flight: Flight, flown: FlownVehicle) -> FlightResult:
    """Return a flight as it was read; what is assumed or doubted is a warning."""
    for note in (*filter(None, [flown.note]), *frame_notes(flight)):
        warnings.warn(note, stacklevel=3)
    return FlightResult(flight, flown.vehicle)


def plot(flights: Mapping[str, FlightResult], kind: FigureKind = "altitude", vehicle: str = "") -> Figure:
    """Return a figure of one vehicle over time, with a curve for each flight, as in the reports.

    Args:
        flights: the flights by their labels.
        kind: altitude [m], horizontal error [m] ("sideways"), vertical push of the air with the predicted
            downwash [m/s^2] ("downwash"), commanded thrust [N] or commanded roll and pitch ("tilt").
        vehicle: name of the vehicle; empty takes the first.

    Raises:
        TypeError: what is given is not flights by their labels.
        ValueError: an unknown kind, no flight, or a vehicle that is not in all flights.
    """
    _check_labelled(flights)
    if kind not in KINDS:
        raise ValueError(f"unknown kind {kind!r}: choose one of {', '.join(KINDS)}")
    name = vehicle or next(iter(flights.values())).names[0]
    for label, flight in flights.items():
        if name not in flight.names:
            raise ValueError(f"no vehicle {name!r} in {label}: choose one of {', '.join(flight.names)}")
    curves = [PlotCurve(one.arrays, label, one.vehicle.thrust_max) for label, one in flights.items()]
    return plot_quantity(KINDS[kind], curves, name)


def page(flights: Mapping[str, FlightResult], path: Path | str, title: str = "") -> Path:
    """Write a page that replays flights side by side in a browser, offline; return its path.

    Args:
        flights: the flights by their labels.
        path: file to write (.html), in a folder that need not exist.
        title: heading; empty takes the labels.

    Raises:
        TypeError: what is given is not flights by their labels.
        ValueError: no flight.
    """
    _check_labelled(flights)
    runs = [
        in_air(replay_run(one.arrays, one.vehicle, label, one.verdict), one.facts.flown_air)
        for label, one in flights.items()
    ]
    html, file = replay_html(runs, title or ", ".join(flights)), Path(path)
    write_text(html, file)
    return file


def _check_labelled(flights: object) -> None:
    """Raise TypeError unless these are flights by their labels, ValueError if there are none."""
    expected = 'must be a mapping of labels to flights, like {"aware": flight}'
    if not isinstance(flights, Mapping):
        raise TypeError(f"flights is {type(flights).__name__}; {expected}")
    for label, flight in flights.items():
        if not (isinstance(label, str) and isinstance(flight, FlightResult)):
            raise TypeError(f"flights has {type(label).__name__}: {type(flight).__name__}; {expected}")
    if not flights:
        raise ValueError("flights is empty: give one or more")


def _shown(controller: str) -> str:
    """Return a controller of q2q in capitals, a class as it is."""
    return controller.upper() if controller in CONTROLLERS else controller
