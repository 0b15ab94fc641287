"""Plans with risk: how many vehicles a room holds, and how far vehicles stray in the flights of such plans.

    python benchmarks/risk.py capacity --tube 0.08 0.06 --draws 3
    python benchmarks/risk.py tube --tube 0.08 0.06 --flights 60 --vehicles 12

`--tube` is that of the plans; `tube` measures one for plans with it. Both swap vehicles at random in a room
(`q2q_planner.experiments.crowded_room`). Flights are those of Crazyflies 2.1 under the interaction-aware PID
that corrects its model `measured_law` (flights dc19), in the air `room` (flights dc21), with the noise,
delays and losses of a real room; `--attitude firmware` flies the emulated stock controller on board.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np

from q2q_model.commands.command_line import CommandLine, run_command
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.geometry.zone import Ellipsoid, Zone
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import GRAVITY, vehicle_by_name
from q2q_planner.experiments.crowded_room import CrowdedError, RoomSize, plan_swap, random_swap
from q2q_planner.offline.zones.risk_zone import RiskParams, RiskTube, risk_zone
from q2q_planner.tools.risk_options import MANOEUVRES, MODEL
from q2q_sim.experiments.promise.tracking_tube import conformal_bound, fewest_flights
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.scenarios.room_profiles import REAL
from q2q_sim.scenarios.scenario import AttitudeLoop, Scenario
from row import Row

VEHICLE = vehicle_by_name("crazyflie_2_1")
ALPHA = 0.01
HOLD = VEHICLE.rpyt_thrust_max / VEHICLE.mass - GRAVITY - MANOEUVRES
ROOM = RoomSize()
SIZES = (4, 6, 8, 11, 16, 22, 32, 45, 64, 90)
"""Swarms tried: half an octave apart."""
GAINS = {"pid": {"k_p_z": 10.0, "k_d_z": 5.0, "k_p_xy": 6.0, "k_d_xy": 4.0}}
"""Those of the real flights dc21."""
SHORT, TUBE = 1, RiskTube(0.08, 0.06, 0.5 * ALPHA)
"""Flights of `scripts/bench`, and the tube of their plans: a guess."""
EXAMPLE = """  python benchmarks/risk.py capacity --tube 0.08 0.06 --draws 3
  python benchmarks/risk.py tube --tube 0.08 0.06 --flights 60 --vehicles 12"""


def risk_of(tube: RiskTube) -> Zone:
    """Return the zone at ALPHA with a tube."""
    return risk_zone(find_model(MODEL).interaction, RiskParams(ALPHA, HOLD, tube), REAL_FLIGHTS)


def zones(tube: RiskTube) -> dict[str, tuple[Zone, float]]:
    """Return the zones compared, and the thrust that each keeps in reserve [m/s^2]."""
    return {
        f"risk {ALPHA:g}": (risk_of(tube), HOLD),
        "ellipsoids 0.12 / 0.30 m around each": (Ellipsoid(0.24, 0.60), 0.0),
        "ellipsoid 0.12 / 0.30 m between centres": (Ellipsoid(0.12, 0.30), 0.0),
    }


def capacity(zone: Zone, reserve: float, seed: int) -> int:
    """Return the largest of SIZES up to which a room holds a random swap of every size."""
    held = 0
    for count in SIZES:
        generator = np.random.default_rng([seed, count])
        try:
            swarm = random_swap(count, zone, ROOM, generator)
        except CrowdedError:
            return held
        if plan_swap(swarm, zone, ROOM, (VEHICLE, reserve)) is None:
            return held
        held = count
    return held


@dataclass(frozen=True, slots=True, eq=False)
class Strays:
    """Largest distances from the reference in a flight, and what became of its pairs."""

    horizontal: Array
    """[m], (n,)"""
    vertical: Array
    """[m], (n,)"""
    nearest: float
    """Minimum distance of two vehicles [m]."""


def strays(count: int, zone: Zone, seed: int, attitude: AttitudeLoop = "paper") -> Strays | None:
    """Return how far vehicles with an attitude loop stray in a random swap; None if it has no plan."""
    try:
        swarm = random_swap(count, zone, ROOM, np.random.default_rng([seed, count]))
    except CrowdedError:
        return None
    plan = plan_swap(swarm, zone, ROOM, (VEHICLE, HOLD))
    if plan is None:
        return None
    scenario = Scenario(
        name="swap",
        description="random swap",
        duration=ROOM.time,
        vehicle=VEHICLE,
        waypoints=swarm,
        plan=plan,
        air="room",
        attitude=attitude,
        model=MODEL,
        vicon=REAL.vicon,
        radio=REAL.radio,
        imu=REAL.imu,
        disturbance=REAL.disturbance,
        overrides=GAINS,
    )
    model = find_model(MODEL).interaction
    flight = fly(scenario, FlightOptions(seed=seed, model=model, residual_process=REAL_FLIGHTS))
    off = np.abs(flight.true_pos - flight.ref_pos)  # (T, n, 3)
    i, j = np.triu_indices(count, 1)
    apart = np.linalg.norm(flight.true_pos[:, i] - flight.true_pos[:, j], axis=-1)
    return Strays(np.hypot(off[..., 0], off[..., 1]).max(axis=0), off[..., 2].max(axis=0), float(apart.min()))


def conformal(scores: Array, risk: float) -> float:
    """Return the bound that a further score exceeds with probability `risk` (split conformal); may be inf."""
    return conformal_bound(scores, risk) if scores.size >= fewest_flights(risk) else np.inf


def run() -> list[Row]:
    """Return the rows of this area: one flight."""
    return tube_rows(flown(range(SHORT), 6, TUBE), TUBE)


def flown(seeds: range, count: int, tube: RiskTube, attitude: AttitudeLoop = "paper") -> list[Strays]:
    """Return the flights of the swaps that have a plan."""
    zone = risk_of(tube)
    return [found for seed in seeds if (found := strays(count, zone, seed, attitude))]


def tube_rows(flights: Sequence[Strays], tube: RiskTube) -> list[Row]:
    """Return how far vehicles strayed in flights, the tube of half of ALPHA, and how many left that given.

    No more than their number if there are none.
    """
    if not flights:
        return [Row("flights", 0, "")]
    aside = np.concatenate([one.horizontal for one in flights])
    height = np.concatenate([one.vertical for one in flights])
    left = (aside > tube.horizontal) | (height > tube.vertical)
    return [
        Row("flights", len(flights), ""),
        Row("vehicles in them", aside.size, ""),
        Row("largest horizontal error of a vehicle, median", 1e3 * float(np.median(aside)), "mm"),
        Row("  exceeded with probability ALPHA / 4", 1e3 * conformal(aside, ALPHA / 4.0), "mm"),
        Row("  largest", 1e3 * float(aside.max()), "mm"),
        Row("largest vertical error of a vehicle, median", 1e3 * float(np.median(height)), "mm"),
        Row("  exceeded with probability ALPHA / 4", 1e3 * conformal(height, ALPHA / 4.0), "mm"),
        Row("  largest", 1e3 * float(height.max()), "mm"),
        Row("vehicles that left the tube of the plans", int(left.sum()), ""),
        Row("least distance of two vehicles", 1e3 * min(one.nearest for one in flights), "mm"),
    ]


def capacity_rows(seeds: range, tube: RiskTube) -> list[Row]:
    """Return how many vehicles a room holds with each zone: median, least and most over the seeds."""
    rows = []
    for name, (zone, reserve) in zones(tube).items():
        held = [capacity(zone, reserve, seed) for seed in seeds]
        rows += [
            Row(f"vehicles, {name}: median", float(np.median(held)), ""),
            Row("  least", min(held), ""),
            Row("  most", max(held), ""),
        ]
    return rows


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure one of both."""
    return run_command(_parser(), lambda _: _measure, arguments)


def _parser() -> CommandLine:
    made = CommandLine("risk", __doc__, EXAMPLE)
    made.add_argument("what", choices=("capacity", "tube"))
    made.add_argument("--draws", type=int, default=3, help="random rooms of each zone (default 3)")
    made.add_argument("--first", type=int, default=0, help="seed of the first flight (default 0)")
    made.add_argument("--flights", type=int, default=60, help="how many flights (default 60)")
    made.add_argument("--vehicles", type=int, default=12, help="in each (default 12)")
    made.add_argument(
        "--attitude", choices=get_args(AttitudeLoop), default="paper", help="loop on board (default paper)"
    )
    made.add_argument(
        "--tube", type=float, nargs=2, required=True, metavar=("HORIZONTAL", "VERTICAL"), help="[m]"
    )
    return made


def _measure(args: Namespace) -> int:
    tube = RiskTube(args.tube[0], args.tube[1], 0.5 * ALPHA)
    if args.what == "capacity":
        rows = capacity_rows(range(args.draws), tube)
    else:
        seeds = range(args.first, args.first + args.flights)
        rows = tube_rows(flown(seeds, args.vehicles, tube, args.attitude), tube)
    for row in rows:
        print(f"{row.name:60} {row.value:10.4g} {row.unit}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
