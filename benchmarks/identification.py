"""Time the fast training loss against the paper's, and the fits against what the paper does.

One run, one core, the same flights: six passes as in Table 2, with a known loop and downwash. The paper's
way is measured by the iteration (q2q_model.identification.networks.torch_training, torch, Dormand-Prince) and
reckoned with as many iterations as ours takes, for both take the same steps of Adam on the same loss. For
the same held-out error it is reckoned with the steps that Adam needs to come down to the error of our fit,
at most `LONGEST`.
"""

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import numpy as np

from q2q_model.downwash.envelope_network import EnvelopeNetwork
from q2q_model.downwash.interaction_model import pairs_at_rest
from q2q_model.downwash.jet import PAPER_LAW
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.impulse_response import downwash_response, free_response
from q2q_model.identification.gains.trajectory_gains import gains_by_powell, gains_from_trajectories
from q2q_model.identification.networks.fit import NetworkFitParams, adam, random_weights, ridge_start
from q2q_model.identification.networks.gradient import unpack
from q2q_model.identification.networks.trajectory_loss import FlightTerms, flight_terms, trajectory_loss
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_sim.tools.import_table import flight_table, read_columns, write_bag
from real import FLIGHTS
from row import Row

LOOP = AltitudeLoop(k_p=0.81073, k_d=0.42952)
WAYS = ((0.5, 0.5), (1.0, 0.5), (0.5, 1.5), (1.0, 1.5), (0.5, 0.25), (1.0, 0.25))
"""Gap [m] and speed [m/s] of each flight; the last is held out."""
DT, SECONDS = 0.01, 40.0
"""4001 samples, as the paper's flights."""
NOISE = 2e-4
"""Of measured altitudes [m]: VICON's."""
STEPS = 20
"""Adam's steps that are timed."""
LONGEST = 2000
"""Adam's steps after which the paper's way is given up."""
BAGS = Path(__file__).resolve().parents[1] / "bags"
ALLOWED, ALLOWED_PUBLIC = 5.0, 60.0
"""Time that `identify` may take on them, and on all public flights [s]."""
REFERENCE = "Adam through an adaptive ODE solver, torch"


def run() -> list[Row]:
    """Return the rows of this area."""
    records = [_flight(k, *way) for k, way in enumerate(WAYS)]
    flights = [flight_terms(one, LOOP, (0.6, 6.6)) for one in records]
    start = unpack(_first_weights(), 0.1, 1.1)
    paper, ours = _paper_step(records[:-1], start), _our_step(flights[:-1], start)
    rows = [Row("one step of Adam on (16)", 1e3 * ours, "ms", REFERENCE, paper / ours)]
    rows += _same_error(flights, start, paper)
    return [*rows, _gains(_calm(records[0])), *_whole_identify()]


def _paper_step(records: list[AltitudeRecord], start: EnvelopeNetwork) -> float:
    from q2q_model.identification.networks.torch_training import train

    walk = train(records, LOOP, start)
    next(walk)
    began = process_time()
    next(walk)
    return process_time() - began


def _our_step(flights: list[FlightTerms], start: EnvelopeNetwork) -> float:
    walk = adam(flights, start)
    next(walk)
    began = process_time()
    for _ in range(STEPS):
        next(walk)
    return (process_time() - began) / STEPS


def _same_error(flights: list[FlightTerms], start: EnvelopeNetwork, paper_step: float) -> list[Row]:
    """Fit by ridge regression, and count the paper's steps to the same error on the flight left out."""
    ridge_start(flights[:-1], NetworkFitParams())  # once for the caches
    began = process_time()
    fitted = ridge_start(flights[:-1], NetworkFitParams())
    ours = process_time() - began
    goal = trajectory_loss(fitted, flights[-1:]).loss
    steps, reached = _steps_to(goal, flights, start)
    name = f"{REFERENCE}, {steps} steps" + ("" if reached else " and not there yet")
    return [
        Row("fit to the same held-out error", 1e3 * ours, "ms", name, steps * paper_step / ours),
        Row("held-out mean square error", goal, "m^2"),
    ]


def _steps_to(goal: float, flights: list[FlightTerms], start: EnvelopeNetwork) -> tuple[int, bool]:
    """Return how many of Adam's steps reach a held-out loss, on the exact loss: its path is the paper's."""
    near = None
    for step, (model, _) in enumerate(adam(flights[:-1], start)):
        if step % 20 == 0:
            value = trajectory_loss(model, flights[-1:], near)
            near = value.etas
            if value.loss <= goal or step >= LONGEST:
                return max(step, 1), value.loss <= goal
    raise AssertionError("adam ends never")


def _gains(record: AltitudeRecord) -> Row:
    gains_from_trajectories([record])  # compiles
    began = process_time()
    gains_from_trajectories([record])
    ours = process_time() - began
    began = process_time()
    gains_by_powell([record])
    reference = process_time() - began
    return Row("gains (12)-(13)", 1e3 * ours, "ms", "Powell through solve_ivp", reference / ours)


def _whole_identify() -> list[Row]:
    """Run `identify` on the recorded flights of Table 2, and on all public ones, as a user does."""
    rows = _identified("bags/table2_*", sorted(BAGS.glob("table2_*")), ALLOWED)
    tables = sorted(FLIGHTS.glob("*_ss*.parquet"))
    if not tables:
        print(f"bench: identification: no public flights in {FLIGHTS}: set Q2Q_DATA", file=sys.stderr)
        return rows
    with TemporaryDirectory() as folder:
        bags = [Path(folder) / table.stem for table in tables]
        for table, bag in zip(tables, bags, strict=True):
            write_bag(flight_table(read_columns(table)), bag)
        return rows + _identified(f"{len(bags)} public flights", bags, ALLOWED_PUBLIC)


def _identified(name: str, bags: Sequence[Path], allowed: float) -> list[Row]:
    """Return wall and CPU time of `identify` on bags, figures included."""
    with TemporaryDirectory() as folder:
        out = str(Path(folder) / "model.q2q")
        command = [sys.executable, "-m", "q2q_model.commands.identify", *map(str, bags), "--out", out]
        before, began = getrusage(RUSAGE_CHILDREN), perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        wall, after = perf_counter() - began, getrusage(RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return [
        Row(f"identify {name}, wall", wall, "s", f"the {allowed:g} s allowed", allowed / wall),
        Row(
            f"identify {name}, CPU of the process", spent, "s", f"the {allowed:g} s allowed", allowed / spent
        ),
    ]


def _calm(record: AltitudeRecord) -> AltitudeRecord:
    """Return the same flight without downwash, begun 0.3 m above its reference."""
    start = np.array([[0.3, 0.3], [0.0, 0.0]])
    pos = record.pos.copy()
    pos[..., 2] = record.ref[..., 0] + free_response(LOOP, DT, start, np.zeros(record.commanded_acc.shape))
    pos[..., 2] += NOISE * np.random.default_rng(9).standard_normal(record.commanded_acc.shape)
    return replace(record, pos=pos)


def _first_weights() -> Array:
    """Return weights as torch draws them: uniform within 1 / sqrt(inputs)."""
    rng = np.random.default_rng(1)
    shape = random_weights(rng)
    inner, outer = 1.0 / np.sqrt(2.0), 1.0 / np.sqrt(40.0)
    width = np.tile(np.concatenate((np.full(120, inner), np.full(41, outer))), 2)
    return rng.uniform(-width, width, shape.size)


def _flight(number: int, gap: float, speed: float) -> AltitudeRecord:
    """Return a flight in which Q2 passes over Q1, its altitudes the exact response to the paper's law."""
    ticks = round(SECONDS / DT) + 1
    t = np.arange(ticks) * DT
    y = np.clip(speed * (t - 0.5 * SECONDS), -1.5, 1.5)
    ref = np.zeros((ticks, 2, 3))
    ref[:, :, 0] = [1.0, 1.0 + gap]
    z, eta = ref[..., 0].copy(), np.zeros((ticks, 2))
    for _ in range(20):  # the altitudes that their own downwash make
        rel = np.stack([0.0 * t, y, z[:, 1] - z[:, 0]], axis=-1)
        eta = np.stack(
            [PAPER_LAW.acceleration(s * rel, pairs_at_rest(rel))[:, 2] for s in (1.0, -1.0)], axis=1
        )
        z = ref[..., 0] + downwash_response(LOOP, DT, eta)
    pos = np.zeros((ticks, 2, 3))
    pos[:, 1, 1], pos[..., 2] = y, z + NOISE * np.random.default_rng(number).standard_normal(z.shape)
    still = np.zeros_like(pos)
    none = np.zeros_like(z)
    blank = AltitudeRecord(
        f"pass {number}", ("cf1", "cf2"), DT, t, pos, still, still, ref, none, none, none, 0, 2 * ticks
    )
    return replace(blank, commanded_acc=np.full_like(z, np.nan), feed_forward=np.full_like(z, np.nan))
