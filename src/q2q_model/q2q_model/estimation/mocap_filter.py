"""Causal filter from motion-capture frames to the state of every vehicle, with outlier rejection.

The paper removes outliers from recorded flights (section 2.2). In flight the future is unknown, so each
sample passes gates that share the paper's thresholds (outlier_thresholds), and a vehicle without an
accepted sample coasts at constant velocity. Tracking is in the folders position and attitude, the match of
rows by name in frame_rows. This file is about frames:

- Rows are matched by name. If `names` are given, other names are counted and ignored; otherwise names are
  adopted in the order of their first appearance, and the state grows, but not for good by names that change
  (stray_names).
- A vehicle that is missing from the frame, or NaN, coasts (COASTING) for `coast_s`, then it is LOST: position
  held, velocity zero, attitude held. Age grows in both.
- The first sample of a track is accepted but not trusted: COASTING at age 0, until a second one fits it.
  So is one that passes the gates further than `jump_max` from its prediction, as it may after a gap.
- A vehicle whose quaternions have been upside down since the first has quaternion NaN, so that no controller
  flies it. Its position is measured as that of any other: others avoid it, and compensate its downwash.
- A vehicle never seen is LOST with position and velocity zero, level attitude, and infinite age.
- A repeated stamp returns the last state. An older stamp (stale, reordered) is ignored: it returns the last
  state with the older stamp, COASTING since nobody was there then, and ages grow with the next newer frame.
  So is a stamp far ahead, under which ages have grown by the gap. Stamps that increase for 0.1 s from there
  are followed (q2q_model.signals.clock_resets). Old ones that do mean a clock that was set back: the tracks
  go on in the new time, their last samples as old as the first of these stamps. By more than `clock_jump_s`
  it is another flight, as of a restarted bag: the filter resets.
- Ages and gates grow with a gap between stamps. After a gap beyond `coast_s` a vehicle is lost, and is
  tracked again once its samples have stayed together for `reacquire_s`. Rejected samples from before a gap
  do not count. A gap is more than GAP_S or, where frames come less often, a lost frame (frame_intervals). A
  lost vehicle that is in a frame only once in longer than GAP_S, while frames come often, remains lost.
"""

from dataclasses import replace

import numpy as np

from q2q_model.estimation.attitude.attitude_tracks import AttitudeTracks
from q2q_model.estimation.filter_report import FilterReport, FrameWarnings
from q2q_model.estimation.frame_counts import FrameCounts
from q2q_model.estimation.frame_intervals import FrameIntervals
from q2q_model.estimation.frame_rows import FrameRows, check_shapes, match_rows, new_names, poses_by_track
from q2q_model.estimation.mocap_filter_params import MocapFilterParams, attitude_params, track_params
from q2q_model.estimation.nominal_frame import (
    QUAT_AT,
    extend_memory,
    keep_memory,
    no_poses,
    nominal_frame,
    remember_poses,
)
from q2q_model.estimation.pose_faults import pose_faults
from q2q_model.estimation.position.position_steps import NEEDS_ASSOCIATION, WHOLE
from q2q_model.estimation.position.position_tracks import PositionTracks
from q2q_model.estimation.position.track_update import TrackUpdate
from q2q_model.estimation.stray_names import are_many_lost, kept_tracks
from q2q_model.signals.clock_resets import ClockResetDetector
from q2q_model.signals.stamps import SAME_INSTANT
from q2q_model.signals.values import (
    Array,
    Mask,
    MocapFrame,
    Names,
    Status,
    SwarmState,
    TrackStatus,
    check_unique,
)

_TRACKED, _COASTING, _LOST = (
    np.uint8(one) for one in (TrackStatus.TRACKED, TrackStatus.COASTING, TrackStatus.LOST)
)


class MocapFilter:
    """Tracks of all vehicles; maps frames to states."""

    def __init__(self, params: MocapFilterParams, names: Names) -> None:
        """Track the vehicles `names`, in that order; if none are given, those that appear."""
        check_unique(names)
        self._params = params
        self._given = names
        self._counts = FrameCounts()
        self.reset()

    @property
    def report(self) -> FilterReport:
        """Return the counts so far."""
        return self._counts.report

    @property
    def warnings(self) -> FrameWarnings:
        """Return the vehicles of which the last frame was wrong."""
        found = FrameWarnings(*map(self._named, self._wrong))
        low_rate = 2.0 * self._intervals.period > self._params.coast_s + SAME_INSTANT
        return found._replace(low_rate=self._names) if low_rate else found

    @property
    def refuses_names(self) -> bool:
        """Return whether the last frame has names that were not adopted, as too many vehicles are lost."""
        return self._rows.unknown > 0 and not self._given

    def _named(self, which: Mask) -> Names:
        return tuple(self._names[row] for row in np.flatnonzero(which)) if which.any() else ()

    def reset(self) -> None:
        """Forget every track, and adopted names."""
        self._names: Names = self._given
        count = len(self._names)
        gates = track_params(self._params), attitude_params(self._params)
        self._gates = tuple(gates[0]), tuple(gates[1])
        self._positions, self._attitudes = PositionTracks(gates[0], count), AttitudeTracks(gates[1], count)
        self._last: SwarmState | None = None
        self._old = ClockResetDetector()
        self._intervals = FrameIntervals()
        self._rows = FrameRows()
        self._recent = no_poses(count)
        self._wrong: tuple[Mask, ...] = ()
        self._find_memory()

    def update(self, frame: MocapFrame) -> SwarmState:
        """Return the state of every vehicle at the frame's time; the last one for an old or repeated frame.

        Raises ValueError for arrays that do not match the names.
        """
        check_shapes(frame)
        if self._last is not None:
            behind = self._last.t - frame.t
            if behind < -SAME_INSTANT and not self._old.reject_ahead(frame.t, self._last.t):
                self._old.reset()
            elif behind > SAME_INSTANT and self._old.confirm_reset(frame.t):
                self._counts.add("clock_resets")
                self._set_back(self._last.t - self._old.first)
            else:
                return self._left_out(frame, self._last)
        elif not np.isfinite(frame.t):
            raise ValueError(f"frame.t = {frame.t}; must be the time of the first frame [s]")
        self._last = self._step(frame)
        return self._last

    def _left_out(self, frame: MocapFrame, last: SwarmState) -> SwarmState:
        """Return the last state for another frame: no vehicle was measured there then.

        The frame's poses are remembered, as they may come again under new stamps.
        """
        ahead = frame.t - last.t
        self._counts.add("repeated_frames" if abs(ahead) <= SAME_INSTANT else "stale_frames")
        if not abs(ahead) > SAME_INSTANT:
            return last
        if frame.names == self._rows.names:
            remember_poses(self._by_track(frame), self._recent)
        age = last.age + max(ahead, 0.0)
        lost = (ahead > 0.0) & (age > self._params.coast_s + SAME_INSTANT)
        status = np.where(lost, _LOST, np.where(last.status == _TRACKED, _COASTING, last.status))
        vel, ang_vel_body = (np.where(lost[:, None], 0.0, rate) for rate in (last.vel, last.ang_vel_body))
        return replace(last, t=frame.t, vel=vel, ang_vel_body=ang_vel_body, age=age, status=status)

    def _set_back(self, by: float) -> None:
        """Go on in the time of a clock that was set back [s], or begin another flight."""
        if by > self._params.clock_jump_s:
            self.reset()
            return
        self._positions.set_back(by)
        self._attitudes.set_back(by)
        self._old.reset()

    def _find_memory(self) -> None:
        """Find the tracks' memory, which moves when they grow."""
        self._memory = (*self._positions.memory, self._attitudes.table)
        self._all_tracked = np.full(len(self._names), _TRACKED)

    def _step(self, frame: MocapFrame) -> SwarmState:
        if self._wrong and not self._given and self._last is not None:  # not after a nominal frame
            self._forget_strays(self._last)
        poses, t = self._by_track(frame), frame.t
        if self._last is not None:
            if t - self._last.t > self._intervals.longest:
                self._attitudes.forget_rejected(t)
            if t > self._last.t:
                self._intervals.add(t - self._last.t)
        n = len(poses)
        pos, vel, ang_vel_body = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
        quat, age = np.empty((n, 4)), np.zeros(n)
        out = pos, vel, quat, ang_vel_body
        outcome, turned, repeated = nominal_frame(t, (poses, self._recent), self._gates, self._memory, out)
        if turned and outcome == WHOLE:
            self._wrong = ()
            self._counts.add_frame(self._rows, n)
            return SwarmState(t, self._names, *out, age, self._all_tracked.copy())
        if outcome == NEEDS_ASSOCIATION:
            self._positions.allow_gap(self._intervals.longest)
            tracked = self._positions.associated(t, poses[:, :QUAT_AT].copy(), repeated)
        else:
            tracked = self._positions.followed(outcome, poses[:, :QUAT_AT], pos, vel)
        if not turned:
            held = repeated & ~self._attitudes.never_accepted
            quat = self._quat_of(tracked, np.where(held[:, None], np.nan, poses[:, QUAT_AT:]))
            self._counts.add("attitudes_refused", self._attitudes.update(t, quat))
        remember_poses(poses, self._recent)
        return self._gapped(t, poses, tracked)

    def _gapped(self, t: float, poses: Array, tracked: TrackUpdate) -> SwarmState:
        """Return the state of a tick that is not nominal, after its positions and attitudes were taken."""
        faults = pose_faults(poses, self._params.pos_max)
        unused = self._counts.add_tick(self._rows, ~faults.missing, tracked)
        rejected = unused & ~(faults.outside | tracked.frozen)
        self._wrong = tracked.borrowed, tracked.frozen, *faults, rejected
        age, status = self._age_and_status(t, tracked)
        quat = np.where(self._attitudes.never_upright(t)[:, None], np.nan, self._attitudes.quat)
        moving = tracked.pos, tracked.vel, quat, self._attitudes.ang_vel_body
        return SwarmState(t, self._names, *moving, age, status)

    def _by_track(self, frame: MocapFrame) -> Array:
        """Return the frame's poses in the order of the tracks, (n, 7); NaN where absent."""
        if frame.names != self._rows.names or (self.refuses_names and not are_many_lost(self._last)):
            if not (self._given or are_many_lost(self._last)):
                self._adopt(frame.names)
            self._rows = match_rows(frame.names, self._names)
        return poses_by_track(frame, self._rows, self._names)

    def _quat_of(self, tracked: TrackUpdate, quat: Array) -> Array:
        """Return each track's quaternion; where labels were swapped, the nearer of both vehicles'."""
        if tracked.nominal or not tracked.borrowed.any():
            return quat
        borrowed = np.where(tracked.accepted[:, None], quat[tracked.source], np.nan)
        return self._attitudes.nearest(quat, borrowed)

    def _age_and_status(self, t: float, tracked: TrackUpdate) -> tuple[Array, Status]:
        if tracked.nominal:
            return np.zeros(len(self._names)), np.full(len(self._names), _TRACKED)
        age = self._positions.age(t)
        late = np.where(age <= self._params.coast_s + SAME_INSTANT, _COASTING, _LOST)
        return age, np.where(tracked.trusted, _TRACKED, late)

    def _adopt(self, names: Names) -> None:
        new = new_names(names, self._names)
        self._names += new
        self._positions.grow(len(new))
        self._attitudes.grow(len(new))
        self._recent = extend_memory(self._recent, len(new))
        self._find_memory()

    def _forget_strays(self, last: SwarmState) -> None:
        in_frame = np.isin(np.arange(len(self._names)), self._rows.tracks)
        kept = kept_tracks(last, self._positions.confirmed, in_frame)
        if kept.all():
            return
        self._names = self._named(kept)
        self._positions.keep(kept)
        self._attitudes.keep(kept)
        self._recent = keep_memory(self._recent, kept)
        self._rows = FrameRows()  # matched anew
        self._find_memory()
