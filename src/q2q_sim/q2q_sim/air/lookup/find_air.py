"""Lookup of the air of a flight: a shipped name, a `.air` file, or a class `module:Class`."""

from q2q_model.own_class import OwnClassError, error_line, is_own_class, own_class
from q2q_model.vehicle.constants import CRAZYFLIE_2_0
from q2q_sim.air.air_file import load
from q2q_sim.air.air_names import LAWS, SYNTHETIC, AirError, air_path, is_recorded
from q2q_sim.air.checked_wake import CheckedWake
from q2q_sim.air.room_air import RoomAir, without_terms
from q2q_sim.air.synthetic_airs import synthetic_air
from q2q_sim.air.wake import AirSetup, Wake
from q2q_sim.air.wake_laws import WakeLaw, wake_by_name

FlownAir = WakeLaw | RoomAir | Wake
"""Air that vehicles can fly in."""
TRIAL = AirSetup(vehicle=CRAZYFLIE_2_0, count=3, step=0.002, seed=0)
"""Flight for which a class is tried before the real one."""


def find_air(name: str, off: tuple[str, ...] = ()) -> FlownAir:
    """Return the named air with the terms `off` switched off.

    Raises:
        AirError: there is no such air or term, its file is not valid, or its class fails in a trial.
    """
    if is_recorded(name):
        from q2q_sim.air.learning.recorded_air import recorded_air

        return without_terms(recorded_air(name), off)
    if name in LAWS or is_own_class(name):
        if off:
            raise AirError(f"air {name} has no terms to switch off ({', '.join(off)})")
        return wake_by_name(name) if name in LAWS else _own(name)
    return without_terms(synthetic_air(name) if name in SYNTHETIC else load(air_path(name)), off)


def _own(name: str) -> Wake:
    try:
        found = own_class(name)
    except OwnClassError as error:
        raise AirError(f"air {name}: {error}") from error
    try:
        made = found()
    except (Exception, SystemExit) as error:
        raise AirError(f"air {name}: {found.__name__}() raised {error_line(error)}") from error
    if not isinstance(made, Wake):
        raise AirError(f"air {name}: the class needs methods reset(setup) and push(now)")
    wake = CheckedWake(made)
    wake.reset(TRIAL)
    return wake
