"""Recorder of a flight, tick by tick, into the arrays of q2q_model.flights.flight.Flight."""

import numpy as np

from q2q_model.flights.flight import Flight
from q2q_model.signals.stamps import time_from_stamp
from q2q_model.signals.values import (
    Array,
    Interference,
    MocapFrame,
    Names,
    SwarmCommand,
    SwarmImu,
    SwarmSetpoint,
    SwarmState,
    index_of,
)

_WIDTHS = {
    "mocap_pos": 3, "mocap_quat": 4, "pos": 3, "vel": 3, "quat": 4, "true_pos": 3, "true_vel": 3,
    "true_eta": 3, "ref_pos": 3, "ref_vel": 3, "ref_acc": 3, "safe_pos": 3, "safe_vel": 3, "safe_acc": 3,
    "eta": 3, "thrust": 1, "roll": 1, "pitch": 1, "command_status": 1, "specific_force_body": 3,
    "gyro_body": 3,
}  # fmt: skip


class FlightRecorder:
    """Recorder of a flight in arrays; entries that are not written stay NaN."""

    def __init__(self, names: Names, ticks: int) -> None:
        """Allocate `ticks` ticks of the vehicles `names`."""
        n = len(names)
        self._names = names
        self._stamps = np.full(ticks, np.nan)
        self._arrays: dict[str, Array] = {
            key: np.full((ticks, n) if width == 1 else (ticks, n, width), np.nan)
            for key, width in _WIDTHS.items()
        }

    def frame(self, tick: int, stamp_ns: int, frame: MocapFrame) -> None:
        """Write the motion-capture frame of the tick at stamp_ns."""
        self._stamps[tick] = time_from_stamp(stamp_ns)
        rows = index_of(frame.names, self._names)
        self._arrays["mocap_pos"][tick, rows] = frame.pos
        self._arrays["mocap_quat"][tick, rows] = frame.quat

    def truth(self, tick: int, truth: SwarmState, downwash: Interference, imu: SwarmImu) -> None:
        """Write the true state and the inertial measurements."""
        self._put(tick, truth.names, true_pos=truth.pos, true_vel=truth.vel)
        self._put(tick, downwash.names, true_eta=downwash.acc)
        self._put(tick, imu.names, specific_force_body=imu.specific_force_body, gyro_body=imu.ang_vel_body)

    def state(self, tick: int, state: SwarmState, interference: Interference) -> None:
        """Write the filtered state and the predicted downwash."""
        self._put(tick, state.names, pos=state.pos, vel=state.vel, quat=state.quat)
        self._put(tick, interference.names, eta=interference.acc)

    def setpoints(self, tick: int, planned: SwarmSetpoint, given: SwarmSetpoint) -> None:
        """Write the setpoint of the plan and that of the replanner."""
        self._put(tick, planned.names, ref_pos=planned.pos, ref_vel=planned.vel, ref_acc=planned.acc)
        self._put(tick, given.names, safe_pos=given.pos, safe_vel=given.vel, safe_acc=given.acc)

    def command(self, tick: int, command: SwarmCommand) -> None:
        """Write the command."""
        status = command.status.astype(np.float64)
        self._put(tick, command.names, thrust=command.thrust, roll=command.roll, pitch=command.pitch)
        self._put(tick, command.names, command_status=status)

    def flight(self, name: str) -> Flight:
        """Return the flight."""
        return Flight(name=name, names=self._names, t=self._stamps, **self._arrays)

    def _put(self, tick: int, names: Names, **values: Array) -> None:
        """Write values, whose rows are `names`."""
        rows = index_of(names, self._names)
        for key, some in values.items():
            self._arrays[key][tick, rows] = some
