"""Random run of a campaign from its seed: scenario, controller and faults.

The scenarios are shipped ones, cut to their encounters and flown faster, so that a run lasts seconds.
Vehicles fly with the gains of real flights and an integral: under a battery sag of 15 % of thrust the paper's
loop (K_p 0.81, no integral) has an error of 1.8 m by its own equation, which no fallback can correct. The
paper's bound on thrust does not apply in any mode: 6.6 N carry 0.65 kg (6.38 N) only up to a sag of 3.4 %.
A Crazyflie of today's stock firmware (0.44 N) has 3.1 m/s^2 to spare, and two wakes push with 3.6: stacks fly
with the firmware of the recorded flights (0.59 N), which their scenarios name for learned air.
Half of the runs with the safe replanner fly its default parameters, half those of their scenario: motions of
bounded jerk and a tube (docs/promise.md).
"""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, replace
from functools import cache, cached_property

import numpy as np

from q2q_model.documents.plain_values import from_plain
from q2q_sim.faults.drawn_faults import random_faults
from q2q_sim.faults.faults import Fault
from q2q_sim.loop.flight_blocks import BlockChoices
from q2q_sim.random_streams import stream
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_document import document_in_air, scenario_from_document

Document = dict[str, object]

GAINS = {"k_p_z": 10.0, "k_d_z": 5.0, "k_i_z": 8.0, "k_p_xy": 6.0, "k_d_xy": 4.0, "k_i_xy": 4.0}
"""K_p and K_d: real flights dc21 (scenario stack3). K_i: a sixth of K_p K_d, the stability limit."""
FEWEST_FAULTS, MOST_FAULTS = 1, 4
"""Faults in a run."""
CALM_S = 4.5
"""Time at the end of a run without new faults [s], in which the vehicles must return to their paths."""


@dataclass(frozen=True, slots=True)
class Excerpt:
    """Section of a scenario and its speed."""

    scenario: str
    begin: float
    """[s]; every vehicle is at rest there."""
    end: float
    """[s]"""
    pace: float = 1.0
    """Flight time per second of the scenario [-]."""
    pace_of_detours: float | None = None
    """The same with a replanner, which adds detours [-]; None for no difference."""

    def replanned(self) -> "Excerpt":
        """Return the excerpt for flight with a replanner."""
        return self if self.pace_of_detours is None else replace(self, pace=self.pace_of_detours)


EXCERPTS = (
    Excerpt("table6_room", 0.0, 50.0, 0.2),
    # path error 0.15 m without faults; replanned at 0.45 it is 0.28 m, as its detours are faster
    Excerpt("stack3", 10.0, 32.0, 0.45, pace_of_detours=0.65),
    Excerpt("table2_1", 15.5, 25.0),
    Excerpt("table2_2", 15.5, 25.0),
    Excerpt("table2_3", 15.5, 25.0),
    Excerpt("table2_4", 15.5, 25.0),
    Excerpt("table2_5", 15.5, 25.0),
    Excerpt("table2_6", 15.5, 25.0),
)
ROOMS = ("capture", "real", "rough")


@dataclass(frozen=True)
class Run:
    """One run of a campaign; its scenario is parsed once, so it has no slots."""

    seed: int
    document: Document
    """The scenario as a YAML document."""
    options: BlockChoices

    @cached_property
    def scenario(self) -> Scenario:
        """Return the scenario of the run."""
        return scenario_from_document(f"run {self.seed}", self.document)


def draw_run(seed: int, air: str = "", replan: str = "") -> Run:
    """Return the run of a seed (0 or above).

    An air replaces the wake and disturbance of its scenario; `replan` replaces the replanner drawn.
    """
    rng = stream(seed, "campaign")
    excerpt = EXCERPTS[int(rng.integers(len(EXCERPTS)))]
    room = str(rng.choice(ROOMS))
    options = BlockChoices(
        mode=str(rng.choice(["aware_unlimited", "ignoring"], p=[0.8, 0.2])),
        controller=str(rng.choice(["pid", "mpc"], p=[0.8, 0.2])),
        replan=str(rng.choice(["none", "safe"], p=[0.8, 0.2])),
    )
    options = replace(options, replan=replan or options.replan)
    shipped = _document(excerpt.scenario)
    document = excerpt_document(shipped, excerpt if options.replan == "none" else excerpt.replanned())
    document["room"] = room
    if air:
        document = {**document_in_air(document), "air": air, "room": room}
    most = scenario_from_document("drawn", document).vehicle.thrust_max
    own: Document = {"pid": GAINS | {"thrust_max": most}, "mpc": {"thrust_max": most}}
    document["overrides"] = own
    scenario = scenario_from_document("drawn", document)
    count = int(rng.integers(FEWEST_FAULTS, MOST_FAULTS + 1))
    faults = random_faults(seed, scenario.names, scenario.duration - CALM_S, count)
    document["faults"] = [fault_document(fault) for fault in faults]
    document["overrides"] = own | _replanning(shipped, options, rng)
    return Run(seed, document, options)


def _replanning(shipped: Mapping[str, object], options: BlockChoices, rng: np.random.Generator) -> Document:
    """Return a scenario's overrides of the safe replanner, for half of the runs that fly it."""
    if options.replan != "safe" or rng.random() < 0.5:
        return {}
    overrides = from_plain(Document, shipped.get("overrides", {}), "overrides")
    return {block: values for block, values in overrides.items() if block == "safe_replanner"}


@cache
def _document(scenario: str) -> Mapping[str, object]:
    """Return the document of a shipped scenario, read once; its vehicle has the firmware of learned air."""
    document = library.document(scenario)
    in_air = document.get("in_air", {})
    if not isinstance(in_air, Mapping) or "vehicle" in in_air or "firmware" not in in_air:
        return document
    return {**document, "firmware": in_air["firmware"]}


def excerpt_document(document: Mapping[str, object], excerpt: Excerpt) -> Document:
    """Return a scenario's document from begin to end of an excerpt, at its speed, with a hover at the end."""
    made = deepcopy(dict(document))
    vehicles = made["vehicles"]
    if not isinstance(vehicles, Mapping):
        raise ValueError(f"{excerpt.scenario}: vehicles are missing")  # noqa: TRY004  a bad document
    made["vehicles"] = {name: _excerpt_waypoints(points, excerpt) for name, points in vehicles.items()}
    made["duration"] = (excerpt.end - excerpt.begin) * excerpt.pace
    return made


def _excerpt_waypoints(points: Sequence[Mapping[str, object]], excerpt: Excerpt) -> list[Document]:
    """Return the waypoints of an excerpt, the last before it moved to its begin, the next one to its end."""
    times = [float(str(point["t"])) for point in points]
    first = max(k for k, t in enumerate(times) if t <= excerpt.begin)
    last = min((k for k, t in enumerate(times) if t >= excerpt.end), default=len(times) - 1)
    kept = [
        (min(max(times[k], excerpt.begin), excerpt.end), points[k]["pos"]) for k in range(first, last + 1)
    ]
    return [{"t": round((t - excerpt.begin) * excerpt.pace, 6), "pos": pos} for t, pos in kept]


def fault_document(fault: Fault) -> Document:
    """Return a fault as it stands in a scenario document."""
    return asdict(fault) | {"vehicles": list(fault.vehicles)}
