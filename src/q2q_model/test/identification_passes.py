"""Passes that flew a known jet, as flights for identification, for tests."""

import numpy as np
from made_flights import LOOP, Pass, made_flight

from q2q_model.downwash.envelope_network import EnvelopeNetwork
from q2q_model.identification.gains.altitude_from_flight import altitude_record
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.networks.fit import (
    random_weights,
)
from q2q_model.identification.networks.gradient import unpack
from q2q_model.identification.networks.trajectory_loss import (
    FlightTerms,
    flight_terms,
)
from q2q_model.identification.push.along_flight import Motion, eta_along
from q2q_model.identification.push.push_samples import PushSamples, push_samples
from q2q_model.identification.push.recorded_push import push_of_sensors
from q2q_model.identification.selection.identification_data import IdentificationData
from q2q_model.vehicle.constants import CRAZYFLIE_2_0

FLOWN = [
    Pass(name=f"{gap} {speed}", gap=gap, speed=speed, noise=1e-4)
    for gap, speed in ((0.4, 0.5), (0.5, 1.0), (0.7, 0.3))
]
REACH = (0.6, 6.6)


def records() -> list[AltitudeRecord]:
    """Return the records of the made flights."""
    return [altitude_record(made_flight(one), CRAZYFLIE_2_0) for one in FLOWN]


def terms() -> list[FlightTerms]:
    """Return the made flights for training."""
    return [flight_terms(one, LOOP, REACH) for one in records()]


def identification_data() -> list[IdentificationData]:
    """Return the made flights with the pushes that their sensors show."""
    return [
        IdentificationData((record,), tuple(pushes(one)))
        for record, one in zip(records(), FLOWN, strict=True)
    ]


def pushes(made: Pass) -> list[PushSamples]:
    """Return the pushes of one made flight."""
    found = push_of_sensors(made_flight(made), CRAZYFLIE_2_0, LOOP.lag)
    assert found is not None
    return push_samples(found)


def random_model(seed: int) -> EnvelopeNetwork:
    """Return networks of a tenth of a m/s^2."""
    rng = np.random.default_rng(seed)
    return unpack(random_weights(rng) + 0.02 * rng.standard_normal(322), 0.1, 1.1)


def eta_error(model: object, made: Pass) -> float:
    """Return the rms error of the learned eta over visited states, over the rms of the true one."""
    flight, record = made_flight(made), altitude_record(made_flight(made), CRAZYFLIE_2_0)
    found = eta_along(model, Motion(record.t, record.pos, record.vel, record.axis))[..., 2]  # type: ignore[arg-type]
    true = flight.true_eta[..., 2]
    visited = np.abs(true).max(axis=1) > 1e-3
    return float(np.sqrt(((found - true)[visited] ** 2).sum() / (true[visited] ** 2).sum()))
