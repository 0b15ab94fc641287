"""What jet and absorption leave of the measured downwash of each vehicle under another."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from q2q_model.identification.push.push_samples import PushSamples
from q2q_model.signals.values import Array
from q2q_sim.air.air_terms import AbsorptionTerm, JetTerm
from q2q_sim.air.learning.jet.learned_downwash import learned_downwash
from q2q_sim.air.learning.records.air_record import AirRecord
from q2q_sim.air.learning.statistics.autocovariance import Lags, autocovariance, flight_lags

LAGS = np.array([0.0, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.16, 0.2])
"""Lags of the autocovariance [s], or those of a flight nearest to them; up to twice the time found."""
FEWEST_CLEAR = 200
"""Fewest rows for a flight's own clear air: 2 s at 100 Hz."""


@dataclass(frozen=True, slots=True)
class WakeResiduals:
    """Residuals of one vehicle of a flight on its exposed rows."""

    record: AirRecord
    one: PushSamples
    eta: Array
    """|eta| [m/s^2], (T,); 0 where not exposed."""
    residual: Array
    """[m/s^2], (T,)"""
    lags: Lags
    """Those of its flight, (L,)."""
    clear: Array
    """Its autocovariance in clear air at each lag, (L,)."""


def wake_residuals(
    records: Sequence[AirRecord], jet: JetTerm, absorption: AbsorptionTerm | None
) -> list[WakeResiduals]:
    """Return what jet and absorption leave of each vehicle that has exposed rows."""
    wakes = [
        _wake(record, one, jet, absorption)
        for record in records
        for one in record.samples
        if one.exposed.any()
    ]
    return _with_clear_air(wakes)


def _wake(
    record: AirRecord, one: PushSamples, jet: JetTerm, absorption: AbsorptionTerm | None
) -> WakeResiduals:
    rows = np.flatnonzero(one.exposed)
    eta = np.zeros(one.y.size)
    eta[rows] = learned_downwash(record, one.vehicle, rows, jet, absorption)
    clear = record.clear[:, one.vehicle]
    lags = flight_lags(record.motion.t, LAGS)
    own = np.zeros(lags.ticks.size)
    if clear.sum() >= FEWEST_CLEAR:
        own = autocovariance(one.y - one.y[clear].mean(), clear, lags)
    return WakeResiduals(record, one, eta, one.y + eta, lags, own)


def _with_clear_air(wakes: Sequence[WakeResiduals]) -> list[WakeResiduals]:
    """Return the wakes with the mean autocovariance of clear air where a flight has none."""
    known = [one for one in wakes if one.clear.any()]
    if not known:
        return list(wakes)
    return [one if one.clear.any() else replace(one, clear=_usual(known, one.lags.times)) for one in wakes]


def _usual(known: Sequence[WakeResiduals], lags: Array) -> Array:
    """Return the mean autocovariance of clear air at lags [s], (L,)."""
    return np.asarray(np.mean([np.interp(lags, one.lags.times, one.clear) for one in known], axis=0))


def vehicle_gain(wake: WakeResiduals) -> float:
    """Return the vehicle's gain on the mean downwash [-]; 1 where there is none."""
    square = float(wake.eta @ wake.eta)
    return -float(wake.one.y @ wake.eta) / square if square > 0.0 else 1.0


def with_vehicle_gain(wake: WakeResiduals) -> WakeResiduals:
    """Return what is left with the vehicle's own gain."""
    return replace(wake, residual=wake.one.y + vehicle_gain(wake) * wake.eta)
