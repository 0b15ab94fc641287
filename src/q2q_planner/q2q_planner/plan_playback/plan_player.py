"""Player of a plan, tick by tick: from a given stamp, from the first tick or, waiting, by calls.

    rest -- transit --> on its way, then at the first points -- start --> the plan, then at its last points
                              |                                        |
                              +------------ hold: braking, rest <------+

While waiting (`wait`), the reference follows the measured vehicles, but not outliers of one frame: it
commands no motion. Nothing would keep vehicles in flight where they are, and `wait` is refused while one is
at its reference. After a low flight one that has landed is there, too: `wait_landed` is for callers that know
it has. Calls never make the reference jump: a transit starts where it rests, the plan starts where the
transit has ended. They act at the newest stamp, whatever late frames come after it, or ones far ahead; in
play, frames that are off by more than SET_BACK_S get the last reference under their stamps. If the clock
steps by more, or frames pause, what was called (a transit, a start, a hold) goes on from there, and so does a
plan that began with the first tick; but that begins again with a clock that was set back, unless it comes
back from a step ahead (q2q_model.signals.clock_resets). A plan with a given start keeps to its stamps.
"""

from dataclasses import dataclass, replace

import numpy as np

from q2q_model.counted import listed
from q2q_model.node.reply import Reply
from q2q_model.signals.clock_resets import SET_BACK_S
from q2q_model.signals.repeated_stamp import StampOrder
from q2q_model.signals.values import Array, MocapFrame, SwarmSetpoint
from q2q_model.trajectory.polynomials import SwarmPlan, setpoint_at
from q2q_planner.plan_playback.braked_plan import brake_plan
from q2q_planner.plan_playback.measured_poses import SEEN_AT_REST, MeasuredPoses, RestingReference
from q2q_planner.plan_playback.transit import TransitParams, transit_plan, wrap_angles

AT_FIRST = 1e-3
"""Largest distance of the reference from the first points at which the plan may start [m]."""
AT_REST = 1e-3
"""Speed [m/s] and yaw rate [rad/s] below which the reference is at rest."""
FLOWN_WITHIN = 0.25
"""Distance from its reference within which a vehicle is taken to fly at it [m]."""


@dataclass(frozen=True, slots=True)
class Played:
    """Plan that is played, and its start."""

    plan: SwarmPlan
    start: float
    """Stamp of its start [s]."""
    called: bool = False
    """Whether a call began it."""
    stops: bool = False
    """Whether it brakes another one."""

    @property
    def start_ns(self) -> int:
        """Return the start [ns]."""
        return round(self.start * 1e9)


class PlanPlayer:
    """Plan that is played, and the last measured positions."""

    def __init__(self, plan: SwarmPlan, start: float, params: TransitParams, *, wait: bool) -> None:
        """Play from the stamp `start` [s], from the first tick if it is negative, or wait for calls.

        Raises:
            ValueError: both a stamp and a wait were given.
        """
        if wait and start >= 0.0:
            raise ValueError(
                f"start = {start:g} s and wait: a waiting plan starts when ~/start is called; give one of "
                "them"
            )
        self._plan, self._params, self._wait = plan, params, wait
        self._at_first_tick = start < 0.0
        self.played = Played(plan, start) if start >= 0.0 else None
        """None while waiting."""
        self._measured = MeasuredPoses(plan.names)
        self._resting = RestingReference(plan.names)
        self._last: SwarmSetpoint | None = None  # at the newest stamp
        self._order = StampOrder()
        self._ahead = 0.0  # the last step ahead [s]; 0 once the clock was set back

    def update(self, frame: MocapFrame) -> SwarmSetpoint:
        """Return the reference at a frame.

        Raises:
            ValueError: while waiting, a vehicle has not been measured yet.
        """
        measured = self._measured.update(frame)
        last = self._last
        if last is None:
            self._order.reset()
        is_late = self._order.reject_stamp(frame.t)
        if last and self._order.was_set:
            self._follow_clock(frame.t, last.t)
        if self.played and last and is_late and not 0.0 <= last.t - frame.t <= SET_BACK_S:
            return replace(last, t=frame.t)
        if self.played is None and not self._wait:
            self.played = Played(self._plan, frame.t)
        if self.played is None:
            poses = self._measured.complete_poses()
            setpoint = self._resting.update(poses, measured, frame.t, is_late=is_late)
        else:
            setpoint = _at(self.played, frame.t)
        if not is_late:
            self._last = setpoint
        return setpoint

    def wait(self) -> Reply:
        """Wait: let the reference follow the measured vehicles, which do not fly at it."""
        if refusal := self._flown():
            return Reply(granted=False, reason=refusal)
        return self.wait_landed()

    def wait_landed(self) -> Reply:
        """Wait, for a caller that has found all vehicles on the ground."""
        if self.played is not None:
            self._resting.reset()
        self.played, self._wait = None, True
        return Reply(granted=True, reason="waiting")

    def transit(self) -> Reply:
        """Lead the reference from its rest to the plan's first points."""
        here = self._rest()
        if isinstance(here, Reply):
            return here
        try:
            plan = transit_plan(self._plan.names, here, self._first(), self._params)
        except ValueError as refusal:
            return Reply(granted=False, reason=str(refusal))
        self.played = Played(plan, self._now(), called=True)
        return Reply(granted=True, reason=f"in transit for {plan.duration:.1f} s, certified")

    def start(self) -> Reply:
        """Start the plan's clock."""
        here = self._rest()
        if isinstance(here, Reply):
            return here
        if self.played is None:
            return Reply(granted=False, reason="the reference follows the measured vehicles: transit first")
        off = here - self._first()
        far, turned = np.linalg.norm(off[:, :3], axis=1), np.abs(wrap_angles(off[:, 3]))
        row = int(np.maximum(far, turned).argmax())
        if max(far[row], turned[row]) > AT_FIRST:
            state = f"{self._plan.names[row]}'s reference is {far[row]:.2f} m and {turned[row]:.2f} rad"
            return Reply(granted=False, reason=f"{state} from its first point: transit first")
        self.played = Played(self._plan, self._now(), called=True)
        return Reply(granted=True, reason=f"the plan has started and takes {self._plan.duration:.1f} s")

    def hold(self) -> Reply:
        """Brake along what is played, if it does not brake already."""
        if self.played is None or self._last is None:
            return Reply(granted=False, reason="nothing is playing")
        now = self._now()
        if not self.played.stops:
            braking = brake_plan(self.played.plan, now - self.played.start)
            self.played = Played(braking, now, called=True, stops=True)
        left = max(self.played.start + self.played.plan.duration - now, 0.0)
        return Reply(granted=True, reason=f"at rest in {left:.1f} s")

    def _follow_clock(self, t: float, last: float) -> None:
        """Follow a clock that was set, under whose stamp t [s] the last one is `last` [s]."""
        if by := self._order.set_back:
            self._set_back(by, last - by)
        else:
            self._ahead = t - last
            self._shift(self._ahead)

    def _set_back(self, by: float, first: float) -> None:
        """Follow a clock that was set back `by` [s], to `first` [s]."""
        if by <= SET_BACK_S and not self._ahead:
            return
        again = not (self.played is None or self.played.called) and self._at_first_tick
        if again and abs(by - self._ahead) > SET_BACK_S:
            self.played = Played(self._plan, first)
        else:
            self._shift(-by)
        self._ahead = 0.0

    def _shift(self, by: float) -> None:
        """Shift what is played by a step of the clock [s], unless it has its own stamp."""
        if self.played is not None and (self.played.called or self._at_first_tick):
            self.played = replace(self.played, start=self.played.start + by)

    def _rest(self) -> Array | Reply:
        """Return the reference at rest, (n, 4), or why it is not at rest."""
        last = self._last
        if last is None:
            return Reply(granted=False, reason="no vehicle has been measured yet")
        speed, turn = np.linalg.norm(last.vel, axis=1), np.abs(last.yaw_rate)
        row = int(np.maximum(speed, turn).argmax())
        if max(speed[row], turn[row]) > AT_REST:
            state = f"{last.names[row]}'s reference moves at {speed[row]:.2f} m/s and {turn[row]:.2f} rad/s"
            return Reply(granted=False, reason=f"{state}: hold first")
        if self.played is None and self._resting.unconfirmed:
            state = f"{listed(self._resting.unconfirmed)} has not been measured at rest in two frames yet"
            return Reply(granted=False, reason=f"{state}: call again")
        if self.played is None and self._resting.speed > SEEN_AT_REST:
            state = f"a measured position has moved at {self._resting.speed:.1f} m/s"
            return Reply(granted=False, reason=f"{state} since the frame before: keep the vehicles at rest")
        return np.column_stack([last.pos, last.yaw])

    def _flown(self) -> str:
        """Return which vehicle is at the reference that is played; empty if none is."""
        if self.played is None or self._last is None:
            return ""
        far = np.linalg.norm(self._measured.known_poses()[:, :3] - self._last.pos, axis=1)
        for name, off in zip(self._plan.names, far.tolist(), strict=True):
            if off <= FLOWN_WITHIN:
                state = f"{name} is {off:.2f} m from its reference and would drift in flight"
                return f"{state}; hold or land it first, or call wait_landed if it stands there"
        return ""

    def _first(self) -> Array:
        return np.stack([curve.at(np.array(0.0)) for curve in self._plan.trajectories])

    def _now(self) -> float:
        return 0.0 if self._last is None else self._last.t


def _at(played: Played, t: float) -> SwarmSetpoint:
    return setpoint_at(played.plan, t, played.start)
