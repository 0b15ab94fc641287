"""Turn frames of motion capture into the state of every vehicle, causally and without believing nonsense.

The paper removes outliers from recorded flights (section 2.2); in flight the future is not known, so each
sample passes gates on position and velocity that share the paper's thresholds (q2q_model.flights.outliers),
and a vehicle without a believable sample coasts at constant velocity. How tracks live is told in
q2q_model.estimation (positions, attitudes, swaps, rivals). This file is about frames:

- Rows are matched by name. With `names` given, other names are counted and ignored; with none given, names
  are adopted in the order of their first appearance, and the state grows.
- A vehicle that is not in the frame, or NaN, coasts (COASTING) for `coast_s`, then it is LOST: position held,
  velocity zero, attitude held. Age grows in both.
- A first sample ever is taken but not trusted: COASTING at age 0, until a second one fits it.
- A vehicle never seen is LOST with position and velocity zero, level, and age infinite. Read the status.
- A repeated stamp gets the same answer again. An older stamp (stale, reordered) is ignored: it gets the last
  answer again, under its own stamp, and ages grow with the next newer frame. A stamp older by more than
  `clock_jump_s`, or old stamps that rise for 0.1 s (q2q_model.estimation.clock_resets), are a clock that was
  set back, or a bag that starts again: everything is forgotten.
- The age and the gates grow with a gap of stamps. After a gap beyond `coast_s` a vehicle is lost, and is
  tracked again once its samples have stayed together for `reacquire_s`.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from q2q_model.estimation.attitudes import AttitudeGateParams, AttitudeTracks
from q2q_model.estimation.clock_resets import ClockResetDetector
from q2q_model.estimation.positions import PositionTracks, TrackParams
from q2q_model.estimation.reacquisition import SAME_INSTANT
from q2q_model.estimation.sample_fate import SampleFates
from q2q_model.estimation.usual_frame import POS, QUAT, RATE, VEL
from q2q_model.flights.outliers import Mask, OutlierThresholds
from q2q_model.signals.values import Array, MocapFrame, Names, Status, SwarmState, TrackStatus
from q2q_model.tunable import check_bounds, tunable

_LIMITS = OutlierThresholds()


@dataclass(frozen=True, slots=True)
class MocapFilterParams:
    """Parameters of the mocap filter."""

    pos_max: float = tunable(_LIMITS.pos_max, "largest believable |x|, |y|, |z|", unit="m", low=0.1)
    speed_max: float = tunable(_LIMITS.speed_max, "largest believable speed", unit="m/s", low=0.1, high=100.0)
    jump_max: float = tunable(
        _LIMITS.jump_max, "largest believable deviation from motion", unit="m", low=1e-4, high=10.0
    )
    # VICON: 0.15 mm static, under 2 mm dynamic (Merriaux et al., Sensors 2017)
    position_noise: float = tunable(
        1e-3,
        "standard deviation of a sample; 0 passes positions through",
        unit="m",
        low=0.0,
        high=0.1,
    )
    # on real flights (nanobench) the velocity error changes by 10 % from 4 to 16
    jerk_noise: float = tunable(8.0, "root power density of the jerk", unit="m/s^2.5", low=1e-3, high=1e4)
    # rooms report dropouts of 0.1 to 0.3 s
    coast_s: float = tunable(
        0.35, "how long a vehicle without samples coasts before it is lost", unit="s", low=0.0, high=10.0
    )
    reacquire_s: float = tunable(
        0.06, "how long refused samples must stay together to be a true jump", unit="s", low=0.0, high=10.0
    )
    turn_max: float = tunable(0.35, "believable turn beyond turn_rate_max", unit="rad", low=0.01, high=3.2)
    # the Crazyflie's gyroscope saturates at 2000 deg/s; in flight it stays below a third of that
    turn_rate_max: float = tunable(12.0, "largest believable body rate", unit="rad/s", low=0.1, high=100.0)
    rate_filter_s: float = tunable(0.02, "lag of the body rate; 0 is none", unit="s", low=0.0, high=1.0)
    attitude_reacquire_s: float = tunable(
        0.3, "how long a refused attitude must last to be believed", unit="s", low=0.0, high=10.0
    )
    clock_jump_s: float = tunable(1.0, "a stamp older by more resets the filter", unit="s", low=0.0, high=1e6)

    def __post_init__(self) -> None:
        """Refuse values out of bounds."""
        check_bounds(self)


IDEAL_SENSING = MocapFilterParams(position_noise=0.0, rate_filter_s=0.0)
"""For a simulated room without noise: positions pass through, velocities to 4e-5 m/s."""


@dataclass(frozen=True, slots=True)
class FilterReport:
    """Counts of the filter since its start (resets do not clear them)."""

    frames: int = 0
    """Frames taken."""
    samples: int = 0
    """Samples offered by vehicles of the swarm: finite positions."""
    refused: int = 0
    """Samples refused by a gate."""
    swapped: int = 0
    """Samples taken for the vehicle they fit instead of the one they name."""
    restarted: int = 0
    """Tracks begun anew: true jumps, and vehicles found again."""
    attitudes_refused: int = 0
    """Quaternions refused by the gate on turning."""
    not_finite: int = 0
    """Rows of the frame without a position."""
    unknown_names: int = 0
    """Rows of vehicles that are none of ours."""
    repeated_names: int = 0
    """Rows whose name stood before in the same frame; the first counts."""
    stale_frames: int = 0
    """Frames older than the last one, or without a time."""
    repeated_frames: int = 0
    """Frames with the last one's stamp."""
    clock_resets: int = 0
    """Times the clock was set back and all was forgotten."""


class MocapFilter:
    """Tracks of all vehicles; maps frames to states."""

    def __init__(self, params: MocapFilterParams, names: Names) -> None:
        """Track the vehicles `names`, in that order; none named means whoever appears."""
        if len(set(names)) < len(names):
            raise ValueError(f"vehicle names repeat: {', '.join(names)}; each may stand once")
        self._params = params
        self._given = names
        self._counts = {entry.name: 0 for entry in fields(FilterReport)}
        self.reset()

    @property
    def report(self) -> FilterReport:
        """Return the counts so far."""
        return FilterReport(**self._counts)

    def reset(self) -> None:
        """Forget every track, and adopted names."""
        self._names: Names = self._given
        count = len(self._names)
        self._positions = PositionTracks(_track_params(self._params), count)
        self._attitudes = AttitudeTracks(_attitude_params(self._params), count)
        self._last: SwarmState | None = None
        self._old = ClockResetDetector()
        self._order: Names = ()
        self._rows: NDArray[np.intp] = np.zeros(0, dtype=np.intp)
        self._offered = 0  # rows of a frame that belong to a track
        self._in_order = False
        self._pose: Array = np.full((count, 7), np.nan)  # this frame's positions and quaternions
        self._heard: Array = np.full((count, 7), np.nan)  # the last frame's

    def update(self, frame: MocapFrame) -> SwarmState:
        """Return the state of every vehicle at the frame's time; an old or repeated frame gets the last one.

        Raises ValueError for arrays that do not fit the names.
        """
        _check_shapes(frame)
        if self._last is not None:
            behind = self._last.t - frame.t
            if self._is_set_back(frame.t, behind):
                self._counts["clock_resets"] += 1
                self.reset()
            elif not behind < -SAME_INSTANT:
                self._counts["repeated_frames" if abs(behind) <= SAME_INSTANT else "stale_frames"] += 1
                return replace(self._last, t=frame.t) if behind > SAME_INSTANT else self._last
        elif not np.isfinite(frame.t):
            raise ValueError(f"frame.t = {frame.t}: a first frame needs a time [s]")
        self._last = self._step(frame)
        return self._last

    def _is_set_back(self, t: float, behind: float) -> bool:
        if behind <= SAME_INSTANT:
            if behind < -SAME_INSTANT:
                self._old.reset()
            return False
        return behind > self._params.clock_jump_s or self._old.rise(t)

    def _step(self, frame: MocapFrame) -> SwarmState:
        self._by_track(frame)
        now = np.empty((len(self._names), 13))  # columns of tracking.glide
        verdict = None
        if not self._positions.glide(frame.t, (self._pose, self._heard), now):
            verdict = self._judged(frame.t, now)
        self._count(frame, verdict)
        pose = self._pose
        if verdict is not None and verdict.lent.any():
            pose = np.hstack([pose[:, :3], self._quat_of(verdict, pose[:, 3:])])
        self._counts["attitudes_refused"] += self._attitudes.update(frame.t, pose)
        now[:, QUAT], now[:, RATE] = self._attitudes.quat, self._attitudes.ang_vel_body
        self._pose, self._heard = self._heard, self._pose
        return self._state(frame.t, now, verdict)

    def _judged(self, t: float, now: Array) -> SampleFates:
        pos, quat = self._pose[:, :3], self._pose[:, 3:]
        verdict = self._positions.update(t, pos, self._repeated(pos, quat))
        now[:, POS], now[:, VEL] = verdict.pos, verdict.vel
        return verdict

    def _by_track(self, frame: MocapFrame) -> None:
        """Write the frame's poses into the rows of their tracks; NaN where absent."""
        rows = self._match(frame.names)
        if self._in_order:
            np.concatenate((frame.pos, frame.quat), axis=1, out=self._pose)
            return
        self._pose.fill(np.nan)
        ours = rows >= 0
        self._pose[rows[ours]] = np.hstack([frame.pos[ours], frame.quat[ours]])

    def _repeated(self, pos: Array, quat: Array) -> Mask | None:
        """Return whose pose is that of the last frame to the last digit, (n,); None where nobody's is."""
        pos_before, quat_before = self._heard[:, :3], self._heard[:, 3:]
        if not (pos[:, 0] == pos_before[:, 0]).any():
            return None
        turned = (quat != quat_before) & ~(np.isnan(quat) & np.isnan(quat_before))
        return np.asarray((pos == pos_before).all(axis=1) & ~turned.any(axis=1))

    def _quat_of(self, verdict: SampleFates, quat: Array) -> Array:
        lent = np.where((verdict.source >= 0)[:, None], quat[verdict.source], np.nan)
        return self._attitudes.nearest(quat, lent)

    def _state(self, t: float, now: Array, verdict: SampleFates | None) -> SwarmState:
        age, status = self._age_and_status(t, verdict)
        return SwarmState(
            t=t,
            names=self._names,
            pos=now[:, POS],
            vel=now[:, VEL],
            quat=now[:, QUAT],
            ang_vel_body=now[:, RATE],
            age=age,
            status=status,
        )

    def _age_and_status(self, t: float, verdict: SampleFates | None) -> tuple[Array, Status]:
        if verdict is None or verdict.plain:
            return np.zeros(len(self._names)), np.zeros(len(self._names), dtype=np.uint8)
        age = self._positions.age(t)
        late = np.where(age <= self._params.coast_s + SAME_INSTANT, TrackStatus.COASTING, TrackStatus.LOST)
        return age, np.where(verdict.trusted, TrackStatus.TRACKED, late).astype(np.uint8)

    def _match(self, names: Names) -> NDArray[np.intp]:
        """Return the track of each row of a frame; -1 for rows to ignore."""
        if names == self._order and len(names) == len(self._rows):
            return self._rows
        if not self._given:
            self._adopt(names)
        track_of = {name: row for row, name in enumerate(self._names)}
        self._order = names
        self._rows = np.array([track_of.pop(name, -1) for name in names], dtype=np.intp)
        self._offered = int((self._rows >= 0).sum())
        self._in_order = bool(np.array_equal(self._rows, np.arange(len(self._names))))
        return self._rows

    def _adopt(self, names: Names) -> None:
        new = tuple(name for name in dict.fromkeys(names) if name not in self._names)
        self._names += new
        self._positions.grow(len(new))
        self._attitudes.grow(len(new))
        unseen = np.full((len(new), 7), np.nan)
        self._pose, self._heard = np.vstack([self._pose, unseen]), np.vstack([self._heard, unseen])

    def _count(self, frame: MocapFrame, verdict: SampleFates | None) -> None:
        counts = self._counts
        counts["frames"] += 1
        samples = len(self._names)
        if verdict is not None and not verdict.plain:
            samples = self._count_unusual(verdict)
        counts["samples"] += samples
        if not self._in_order:
            counts["repeated_names"] += len(frame.names) - len(set(frame.names))
            counts["unknown_names"] += len(set(frame.names) - set(self._names))
        counts["not_finite"] += self._offered - samples

    def _count_unusual(self, verdict: SampleFates) -> int:
        """Count what became of samples; return how many there were."""
        counts = self._counts
        if verdict.none_rejected:
            return int(verdict.accepted.sum())
        present = np.isfinite(self._pose[:, :3]).all(axis=1)
        used = np.zeros(len(self._names), dtype=np.bool_)
        used[verdict.source[verdict.accepted]] = True
        counts["swapped"] += int(verdict.lent.sum())
        counts["refused"] += int((present & ~used).sum())
        counts["restarted"] += int(verdict.restarted.sum())
        return int(present.sum())


def _check_shapes(frame: MocapFrame) -> None:
    count = len(frame.names)
    if frame.pos.shape != (count, 3) or frame.quat.shape != (count, 4):
        raise ValueError(
            f"frame at t = {frame.t} has {count} names, pos {frame.pos.shape}, quat {frame.quat.shape}; "
            f"allowed are ({count}, 3) and ({count}, 4)"
        )


def _track_params(params: MocapFilterParams) -> TrackParams:
    return TrackParams(
        limits=OutlierThresholds(params.pos_max, params.speed_max, params.jump_max),
        position_noise=params.position_noise,
        jerk_noise=params.jerk_noise,
        coast_s=params.coast_s,
        reacquire_s=params.reacquire_s,
    )


def _attitude_params(params: MocapFilterParams) -> AttitudeGateParams:
    return AttitudeGateParams(
        turn_max=params.turn_max,
        turn_rate_max=params.turn_rate_max,
        rate_filter_s=params.rate_filter_s,
        reacquire_s=params.attitude_reacquire_s,
        coast_s=params.coast_s,
    )
