"""Tables 1 to 4 and Figs 4 to 9: the six flights of Table 2, and the models learned from them.

Learning does not use the simulator's true states: records have motion capture, references and commands.
"""

from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from time import perf_counter

import numpy as np

from q2q_model import palette
from q2q_model.downwash.envelope_network import EnvelopeNetwork
from q2q_model.downwash.interaction_model import downwash_at_rest
from q2q_model.flights.flight import Flight
from q2q_model.geometry.zone import Cylinder
from q2q_model.identification.deviation import DecayFit, fit_decay, overlaps_of
from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.gains.command_gains import gains_from_commands
from q2q_model.identification.gains.impulse_response import downwash_response, free_response
from q2q_model.identification.gains.trajectory_gains import TOLERANCE, gains_from_trajectories
from q2q_model.identification.networks.fit import adam, fit_networks, random_weights
from q2q_model.identification.networks.gradient import pack, unpack
from q2q_model.identification.networks.trajectory_loss import WIDE, FlightTerms, flight_terms, trajectory_loss
from q2q_model.signals.values import Array
from q2q_model.vehicle.altitude_loop import AltitudeLoop
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.experiments.paper.experiment_outcome import ExperimentOutcome, FigurePicture, Line, plot_panel
from q2q_sim.firmware.motors.battery import LOW_POWER, Battery
from q2q_sim.firmware.parameters.parameter_table import TABLE
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.metrics.flight_metrics import tick_period
from q2q_sim.scenarios import library

FLIGHTS = range(1, 7)
SHOWN = 4
"""Flight of Figs 5 to 9: #5, the longest overlap at the small distance."""
ZONE = Cylinder()
HOVER_STEP_S = 0.1
"""Step of the battery model [s]."""
ADAM_STEPS = 20
"""Number of timed iterations of Adam; one takes milliseconds."""


def vehicle(_: Path) -> ExperimentOutcome:
    """Return the constants of the vehicle and its hover time until the battery is low."""
    x, y, z = CRAZYFLIE_2_0.inertia
    found = {
        "table1.takeoff_weight": 1e3 * CRAZYFLIE_2_0.mass,
        "table1.inertia_xx": x,
        "table1.inertia_yy": y,
        "table1.inertia_zz": z,
        "table1.size": 2e3 * CRAZYFLIE_2_0.arm,
        "table1.flight_time": hover_time() / 60.0,
    }
    return ExperimentOutcome(found)


def hover_time() -> float:
    """Return the hover time of a full battery until the firmware reports it low [s]."""
    low_volt = float(next(one.default for one in TABLE if one.name == "pm.lowVoltage"))
    battery, flown = Battery(), 0.0
    while battery.state != LOW_POWER:
        battery.drain(1.0, HOVER_STEP_S, low_volt)
        flown += HOVER_STEP_S
    return flown


def timed_adam(terms: Sequence[FlightTerms]) -> tuple[float, float]:
    """Return the largest change of a weight in Adam's first step [-], and the time of an iteration [s]."""
    start = unpack(random_weights(np.random.default_rng(0)), ZONE.eps, ZONE.d)
    steps = adam(terms, start)
    started = perf_counter()
    weights = [pack(model) for model, _ in islice(steps, ADAM_STEPS)]
    seconds = (perf_counter() - started) / ADAM_STEPS
    return float(np.abs(weights[1] - weights[0]).max()), seconds


def learning(folder: Path) -> ExperimentOutcome:
    """Fly the six flights and learn loop, zone and downwash from them."""
    flights = [fly(library.load(f"table2_{k}"), FlightOptions(mode="ignoring", seed=k)) for k in FLIGHTS]
    records = [altitude_record(flight, CRAZYFLIE_2_0) for flight in flights]
    by_paper = gains_from_trajectories(records)
    loop = gains_from_commands(records).loop
    decay = known_decay(records)
    terms = [flight_terms(one, loop, (WIDE * ZONE.eps, WIDE * ZONE.d)) for one in records]
    model = fit_networks(terms)
    mse = np.mean(trajectory_loss(model, terms).mse, axis=0)  # all flights are of two
    step_size, seconds = timed_adam(terms)
    eta = predicted_push(model, records[SHOWN])
    found = {
        **_flown(flights),
        "table3.xtol": TOLERANCE,
        "table3.ftol": TOLERANCE,
        "table4.step_size": step_size,
        "table4.seconds_per_iteration": seconds,
        "fig4.d": decay.d.value if decay else np.nan,
        "fig4.beta": decay.beta.value if decay else np.nan,
        "fig5.k_p": by_paper.loop.k_p,
        "fig5.k_d": by_paper.loop.k_d,
        "fig5.k_p_from_commands": loop.k_p,
        "fig5.k_d_from_commands": loop.k_d,
        "fig5.mse_1": float(np.stack(by_paper.mse)[:, 0].mean()),
        "fig5.mse_2": float(np.stack(by_paper.mse)[:, 1].mean()),
        "fig6.mse_1": float(mse[0]),
        "fig7.mse_2": float(mse[1]),
        "fig8.peak_eta_1": float(np.abs(eta[:, 0]).max()),
        "fig9.peak_eta_2": float(np.abs(eta[:, 1]).max()),
    }
    return ExperimentOutcome(
        found, (decay_picture(folder, records, decay), *_learned_pictures(folder, records[SHOWN], loop, eta))
    )


def predicted_push(model: EnvelopeNetwork, record: AltitudeRecord) -> Array:
    """Return the vertical downwash [m/s^2] a model predicts for a flight of two, (T, 2)."""
    rel = record.pos[:, ::-1] - record.pos  # (T, 2, 3), of the other
    return np.asarray(downwash_at_rest(model, rel)[..., 2])


def _flown(flights: Sequence[Flight]) -> dict[str, float]:
    """Return the numbers of Table 2 for each flight."""
    found = {}
    for number, flight in zip(FLIGHTS, flights, strict=True):
        rel = flight.true_pos[:, 1] - flight.true_pos[:, 0]
        across = np.hypot(rel[:, 0], rel[:, 1])
        near = across <= ZONE.eps
        speed = float(np.linalg.norm(flight.true_vel[np.argmin(across), 1, :2]))
        found[f"table2.distance_{number}"] = float(rel[near, 2].mean())
        found[f"table2.speed_{number}"] = speed
        found[f"table2.overlap_{number}"] = float(near.sum()) * tick_period(flight)
    return found


def known_decay(records: Sequence[AltitudeRecord]) -> DecayFit | None:
    """Return the decay of dev; None where the flights show none."""
    try:
        return fit_decay(records)
    except ValueError:
        return None


def decay_picture(folder: Path, records: Sequence[AltitudeRecord], decay: DecayFit | None) -> FigurePicture:
    """Draw the deviations of flights (Fig 4), and their decay if they show one."""
    flown = overlaps_of(records)
    gaps, devs = np.array([(one.gap, one.dev) for one in flown]).reshape(-1, 2).T
    lines = [Line("flights", gaps, devs, "o", palette.MEASURED)]
    if decay is not None:
        along = np.linspace(0.0, 1.5, 100)
        fit = decay.alpha.value * np.exp(-decay.beta.value * along)
        lines.append(Line("fit", along, fit, colour=palette.MODEL))
    title = "fig4: dev against the height difference"
    return FigurePicture("fig4", plot_panel(folder / "fig4.png", title, ("dz [m]", "dev [m]"), lines), title)


def _learned_pictures(
    folder: Path, record: AltitudeRecord, loop: AltitudeLoop, eta: Array
) -> tuple[FigurePicture, ...]:
    """Draw measured and simulated altitudes (Figs 5 to 7) and learned downwash (Figs 8, 9)."""
    free = free_response(loop, record.dt, record.start, record.jerk)
    pushed = free + downwash_response(loop, record.dt, eta)
    made = []
    for row in range(2):
        reference = record.ref[:, row, 0]
        measured = Line("measured", record.t, record.pos[:, row, 2], colour=palette.MEASURED)
        alone = Line("loop alone", record.t, reference + free[:, row], colour=palette.ORANGE)
        both = Line("loop and downwash", record.t, reference + pushed[:, row], colour=palette.MODEL)
        downwash = Line("learned downwash", record.t, eta[:, row], colour=palette.MODEL)
        for group, unit, lines in (
            ("fig5", "z [m]", [measured, alone]),
            (f"fig{6 + row}", "z [m]", [measured, both]),
            (f"fig{8 + row}", "eta z [m/s²]", [downwash]),
        ):
            title = f"{group}: Q{row + 1} in flight #{SHOWN + 1}"
            file = plot_panel(folder / f"{group}_q{row + 1}.png", title, ("t [s]", unit), lines)
            made.append(FigurePicture(group, file, title))
    return tuple(made)
