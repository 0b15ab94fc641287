"""Draw one run of a campaign from its seed: what is flown, by whom, and what goes wrong.

The scenarios are shipped ones, cut to where something happens and flown at a brisk pace, so that a run lasts
seconds. Vehicles fly with the gains of real flights and an integral: the paper's loop (K_p 0.81, no
integral) is moved by 1.8 m where a sagging battery takes 15 % of its thrust, by its own equation; no
fallback mends that. Nor do they fly with the paper's bound on thrust, in any mode: 6.6 N carry 0.65 kg
(6.38 N) only while a battery sags by less than 3.4 %.
"""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, replace

from q2q_sim.faults.faults import Fault, random_faults
from q2q_sim.loop.assembly import Options
from q2q_sim.plant.random_streams import stream
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario, scenario_from_document

Document = dict[str, object]

GAINS = {"k_p_z": 10.0, "k_d_z": 5.0, "k_i_z": 8.0, "k_p_xy": 6.0, "k_d_xy": 4.0, "k_i_xy": 4.0}
"""K_p and K_d: real flights dc21 (scenario stack3). K_i: a sixth of K_p K_d, where stability ends."""
FEWEST, MOST = 1, 4
"""Faults in a run."""
CALM_S = 4.5
"""Time at the end of a run in which no fault begins [s]: its vehicles must be back."""


@dataclass(frozen=True, slots=True)
class Cut:
    """Flown part of a scenario and its speed."""

    scenario: str
    begin: float
    """[s]; every vehicle is at rest then."""
    end: float
    """[s]"""
    pace: float = 1.0
    """Time flown for a second of the scenario [-]."""
    pace_of_detours: float | None = None
    """The same where a replanner adds detours [-]; None for no difference."""

    def replanned(self) -> "Cut":
        """Return the cut as it is flown with a replanner."""
        return self if self.pace_of_detours is None else replace(self, pace=self.pace_of_detours)


CUTS = (
    Cut("table6_room", 0.0, 50.0, 0.2),
    # off its way by 0.15 m without faults; replanned at 0.45 it is by 0.28 m, its detours being faster
    Cut("stack3", 10.0, 32.0, 0.45, pace_of_detours=0.65),
    Cut("table2_1", 15.5, 25.0),
    Cut("table2_2", 15.5, 25.0),
    Cut("table2_3", 15.5, 25.0),
    Cut("table2_4", 15.5, 25.0),
    Cut("table2_5", 15.5, 25.0),
    Cut("table2_6", 15.5, 25.0),
)
ROOMS = ("capture", "real", "rough")


@dataclass(frozen=True, slots=True)
class Run:
    """One run of a campaign."""

    seed: int
    document: Document
    """The scenario, as YAML says it."""
    options: Options

    @property
    def scenario(self) -> Scenario:
        """Return what is flown."""
        return scenario_from_document(f"run {self.seed}", self.document)


def drawn(seed: int) -> Run:
    """Return the run of a seed (0 or above)."""
    rng = stream(seed, "campaign")
    cut = CUTS[int(rng.integers(len(CUTS)))]
    room = str(rng.choice(ROOMS))
    options = Options(
        mode=str(rng.choice(["aware_unlimited", "ignoring"], p=[0.8, 0.2])),
        controller=str(rng.choice(["pid", "mpc"], p=[0.8, 0.2])),
        replan=str(rng.choice(["none", "safe"], p=[0.8, 0.2])),
    )
    document = shortened(library.document(cut.scenario), cut if options.replan == "none" else cut.replanned())
    document["room"] = room
    most = scenario_from_document("drawn", document).vehicle.thrust_max
    document["overrides"] = {"pid": GAINS | {"thrust_max": most}, "mpc": {"thrust_max": most}}
    scenario = scenario_from_document("drawn", document)
    count = int(rng.integers(FEWEST, MOST + 1))
    faults = random_faults(seed, scenario.names, scenario.duration - CALM_S, count)
    document["faults"] = [_as_document(fault) for fault in faults]
    return Run(seed, document, options)


def shortened(document: Mapping[str, object], cut: Cut) -> Document:
    """Return a scenario's document from begin to end of a cut, at its pace, with a calm end."""
    made = deepcopy(dict(document))
    vehicles = made["vehicles"]
    if not isinstance(vehicles, Mapping):
        raise ValueError(f"{cut.scenario}: vehicles are missing")  # noqa: TRY004  a bad document
    made["vehicles"] = {name: _cut_waypoints(points, cut) for name, points in vehicles.items()}
    made["duration"] = (cut.end - cut.begin) * cut.pace
    return made


def _cut_waypoints(points: Sequence[Mapping[str, object]], cut: Cut) -> list[Document]:
    """Return the waypoints of a cut: the last before it holds at its begin, the next after it at its end."""
    times = [float(str(point["t"])) for point in points]
    first = max(k for k, t in enumerate(times) if t <= cut.begin)
    last = min((k for k, t in enumerate(times) if t >= cut.end), default=len(times) - 1)
    kept = [(min(max(times[k], cut.begin), cut.end), points[k]["pos"]) for k in range(first, last + 1)]
    return [{"t": round((t - cut.begin) * cut.pace, 6), "pos": pos} for t, pos in kept]


def _as_document(fault: Fault) -> Document:
    return asdict(fault) | {"vehicles": list(fault.vehicles)}
