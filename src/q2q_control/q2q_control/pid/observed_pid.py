"""PID with a disturbance observer.

    a = r''_ref + K_p (r_ref - r) + K_d (r'_ref - r') + K_i xi - eta - d

d, of q2q_control.disturbance.observer, is faster than the integral xi and does not wind up; the gains K_i are
used as given, and with those above 0 both correct one error. Without a predicted downwash (eta = 0), d
estimates the downwash itself, one time constant late; with one, d estimates the model's error. Position and
velocity are the observer's too. With a residual process, z, z' and d_z are those of
q2q_control.disturbance.residual_observer, from accelerometers too.
"""

import numpy as np

from q2q_control.disturbance.tracker import DisturbanceTracker, TrackerParams
from q2q_control.inputs.alignment import ETA, POS, VEL, align
from q2q_control.pid.pid import Pid
from q2q_control.pid.pid_params import PidParams
from q2q_control.pid.stale_downwash_fade import StaleDownwashFade
from q2q_model.downwash.correction.residual_process import ResidualProcess
from q2q_model.signals.repeated_stamp import is_repeated
from q2q_model.signals.values import Interference, Names, SwarmCommand, SwarmImu, SwarmSetpoint, SwarmState
from q2q_model.vehicle.constants import Vehicle


class ObservedPid:
    """PID with a disturbance observer."""

    def __init__(
        self,
        params: PidParams,
        tracker: TrackerParams,
        vehicle: Vehicle,
        vehicles: Names = (),
        residual_process: ResidualProcess | None = None,
    ) -> None:
        """Control vehicles like `vehicle`: those named, or all of the setpoint.

        `residual_process` is of the prediction: positions and accelerometers (`sense`) correct it.
        """
        self._vehicles = vehicles
        self._pid = Pid(params, vehicle, vehicles)
        self._tracker = DisturbanceTracker(tracker, vehicle, residual_process)
        self._stale_fade = StaleDownwashFade(params.stale_fade)
        self._last: SwarmCommand | None = None

    def configure(self, params: PidParams) -> None:
        """Use other gains and limits from the next stamp on; memory is kept."""
        self._pid.configure(params)

    def sense(self, imu: SwarmImu) -> None:
        """Take accelerometers of a tick; without a residual process they are ignored."""
        self._tracker.sense(imu)

    def reset(self) -> None:
        """Forget all memory."""
        self._pid.reset()
        self._tracker.reset()
        self._stale_fade.reset()
        self._last = None

    def update(
        self, state: SwarmState, setpoint: SwarmSetpoint, interference: Interference | None
    ) -> SwarmCommand:
        """Return the tick's command; `interference` None means that no downwash is predicted."""
        last, names = self._last, self._vehicles or setpoint.names
        if is_repeated(last, setpoint.t, names):
            return last
        if last is not None and setpoint.t < last.t:
            self.reset()
        tick = align(state, setpoint, self._stale_fade.faded(interference), names)
        estimate = self._tracker.update(tick).estimate
        tick.table[:, POS] = np.where(tick.usable[:, None], estimate.pos, tick.table[:, POS])
        tick.table[:, VEL] = np.where(tick.usable[:, None], estimate.vel, tick.table[:, VEL])
        tick.table[:, ETA] += np.where(tick.usable[:, None], estimate.disturbance, 0.0)
        self._last = self._pid.command(tick)
        self._tracker.sent(self._last, tick)
        return self._last
