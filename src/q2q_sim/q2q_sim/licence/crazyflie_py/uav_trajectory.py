"""Piecewise polynomial trajectories in x, y, z and yaw, from CSV files, with the flat outputs' derivatives.

A row of a file: duration [s], then eight coefficients of rising powers of x, y, z [m] and yaw [rad]. The body
rates of a state (D. Mellinger, V. Kumar, ICRA 2011), with force f = acc + g e_z, z = f / |f|, jerk j:

    h = (j - (j . z) z) / |f|      omega = (-h . y,  h . x,  yaw_rate z . e_z)
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from q2q_model.signals.values import Array

GRAVITY = 9.81
"""That of crazyflie_py [m/s^2]."""
COLUMNS = 33


def normalize(v: Array) -> Array:
    """Return a vector of length 1."""
    length = float(np.linalg.norm(v))
    if length == 0.0:
        raise ValueError("a vector of length 0 has no direction")
    return np.asarray(v / length)


class Polynomial:
    """Polynomial with coefficients `p` of rising powers."""

    def __init__(self, p: Sequence[float] | Array) -> None:
        self.p = p

    def eval(self, t: float) -> float:
        """Return the value at t [s]."""
        if t < 0.0:
            raise ValueError(f"t = {t}; must be at least 0")
        return float(np.polynomial.polynomial.polyval(t, np.asarray(self.p)))

    def derivative(self) -> "Polynomial":
        """Return the derivative, whose coefficients are a list: crazyflie_py uploads arrays only."""
        return Polynomial(np.polynomial.polynomial.polyder(np.asarray(self.p)).tolist())


class TrajectoryOutput:
    """State at one time."""

    def __init__(self) -> None:
        self.pos: Array = np.zeros(3)
        self.vel: Array = np.zeros(3)
        self.acc: Array = np.zeros(3)
        self.omega: Array = np.zeros(3)
        self.yaw = 0.0


class Polynomial4D:
    """Piece of a trajectory."""

    def __init__(
        self,
        duration: float,
        px: Sequence[float] | Array,
        py: Sequence[float] | Array,
        pz: Sequence[float] | Array,
        pyaw: Sequence[float] | Array,
    ) -> None:
        self.duration = duration
        self.px, self.py, self.pz, self.pyaw = (Polynomial(one) for one in (px, py, pz, pyaw))

    def derivative(self) -> "Polynomial4D":
        """Return the derivative of every axis."""
        x, y, z, yaw = (one.derivative().p for one in (self.px, self.py, self.pz, self.pyaw))
        return Polynomial4D(self.duration, x, y, z, yaw)

    def eval(self, t: float) -> TrajectoryOutput:
        """Return the state at t [s] after the start of the piece."""
        first = self.derivative()
        second = first.derivative()
        out = TrajectoryOutput()
        out.pos, out.vel, out.acc = self._point(t), first._point(t), second._point(t)  # noqa: SLF001
        out.yaw = self.pyaw.eval(t)
        jerk, force = second.derivative()._point(t), out.acc + np.array([0.0, 0.0, GRAVITY])  # noqa: SLF001
        z = normalize(force)
        y = normalize(np.cross(z, [np.cos(out.yaw), np.sin(out.yaw), 0.0]))
        h = (jerk - (jerk @ z) * z) / np.linalg.norm(force)
        out.omega = np.array([-h @ y, h @ np.cross(y, z), z[2] * first.pyaw.eval(t)])
        return out

    def _point(self, t: float) -> Array:
        return np.array([self.px.eval(t), self.py.eval(t), self.pz.eval(t)])


class UavTrajectory:
    """Trajectory of pieces, which has none, nor a duration, until they are read or set."""

    def __init__(self) -> None:
        self.polynomials: list[Polynomial4D] | None = None
        self.duration: float | None = None

    def n_pieces(self) -> int:
        """Return the number of pieces."""
        return len(pieces_of(self))

    def loadcsv(self, filename: str | Path) -> None:
        """Read a file."""
        rows = np.loadtxt(filename, delimiter=",", skiprows=1, usecols=range(COLUMNS), ndmin=2)
        self.polynomials = [Polynomial4D(row[0], row[1:9], row[9:17], row[17:25], row[25:33]) for row in rows]
        self.duration = np.sum(rows[:, 0])

    def eval(self, t: float) -> TrajectoryOutput:
        """Return the state at t [s]."""
        pieces = pieces_of(self)
        if self.duration is None:
            raise TypeError("a trajectory without a duration: set it to the sum of those of its polynomials")
        if not 0.0 <= t <= self.duration:
            raise ValueError(f"t = {t}; must be in [0, {self.duration}] s")
        begin = 0.0
        for piece in pieces:
            if t <= begin + piece.duration:
                return piece.eval(t - begin)
            begin += piece.duration
        return pieces[-1].eval(pieces[-1].duration)


def pieces_of(trajectory: UavTrajectory) -> list[Polynomial4D]:
    """Return the pieces of a trajectory; raise TypeError if it has none yet, as crazyflie_py does."""
    if trajectory.polynomials is None:
        raise TypeError("a trajectory without polynomials: read a file by loadcsv, or set polynomials")
    return trajectory.polynomials
