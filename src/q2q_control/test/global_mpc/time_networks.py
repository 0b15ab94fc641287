"""Networks of time for r, a and U, section 5.2: one hidden layer, tanh, of the time scaled to -1..1.

Derivatives with respect to time and to the weights are exact.
"""

from dataclasses import dataclass

import numpy as np

from q2q_model.signals.values import Array

OUTPUTS = 6
"""Of a vehicle: x y z [m], phi theta [rad], U1 [m g]."""
NETWORKS = ((0, 1, 2), (3, 4), (5,))
"""Which outputs each network has: r, a, U1."""


@dataclass(frozen=True, slots=True, eq=False)
class TimeNetworks:
    """Networks of some vehicles, evaluated at samples; weights are one flat vector."""

    vehicles: int
    times: Array
    """Of the samples [s], (T,)."""
    hidden: int
    """Units of each hidden layer, h."""

    def random_weights(self, rng: np.random.Generator) -> Array:
        """Return random weights whose networks are near zero: slopes, centres, output weights."""
        h = self.hidden
        steep = rng.normal(size=(self.vehicles, 3, h)) * h / 2.0
        centre = -steep * rng.uniform(-1.0, 1.0, (self.vehicles, 3, h))  # kinks all along the flight
        out = np.zeros((self.vehicles, OUTPUTS, h + 1))
        return np.concatenate([steep.ravel(), centre.ravel(), out.ravel()])

    @property
    def _half(self) -> float:
        return 0.5 * float(self.times[-1] - self.times[0])

    @property
    def _scaled(self) -> Array:
        """Return the times scaled to -1..1, (T,)."""
        scaled: Array = (self.times - self.times[0]) / self._half - 1.0
        return scaled

    @property
    def _own(self) -> int:
        """Return the number of a vehicle's weights."""
        return 6 * self.hidden + OUTPUTS * (self.hidden + 1)

    def _parts(self, weights: Array) -> tuple[Array, Array, Array]:
        """Return slopes and centres of units (n, 3, h), and weights of outputs (n, OUTPUTS, h + 1)."""
        h, n = self.hidden, self.vehicles
        cut = n * 3 * h
        steep = weights[:cut].reshape(n, 3, h)
        centre = weights[cut : 2 * cut].reshape(n, 3, h)
        return steep, centre, weights[2 * cut :].reshape(n, OUTPUTS, h + 1)

    def outputs(self, weights: Array) -> tuple[Array, Array]:
        """Return the networks' outputs and second time derivatives, (n, T, OUTPUTS)."""
        steep, centre, out = self._parts(weights)
        values, seconds = np.empty((2, self.vehicles, self.times.size, OUTPUTS))
        for net, columns in enumerate(NETWORKS):
            hidden = np.tanh(self._scaled[:, None] * steep[:, None, net] + centre[:, None, net])  # (n, T, h)
            curve = -2.0 * hidden * (1.0 - hidden**2) * (steep[:, None, net] / self._half) ** 2
            for column in columns:
                values[..., column] = (hidden * out[:, None, column, :-1]).sum(-1) + out[:, None, column, -1]
                seconds[..., column] = (curve * out[:, None, column, :-1]).sum(-1)
        return values, seconds

    def slopes(self, weights: Array) -> tuple[Array, Array]:
        """Return d outputs and d second derivatives / d a vehicle's own weights, (n, T, OUTPUTS, own)."""
        steep, centre, out = self._parts(weights)
        h, own = self.hidden, self._own
        values, seconds = np.zeros((2, self.vehicles, self.times.size, OUTPUTS, own))
        s = self._scaled[None, :, None]
        for net, columns in enumerate(NETWORKS):
            slope = steep[:, None, net]  # (n, 1, h)
            hidden = np.tanh(s * slope + centre[:, None, net])  # (n, T, h)
            first = 1.0 - hidden**2
            second = -2.0 * hidden * first
            third = first * (6.0 * hidden**2 - 2.0)
            rate = 1.0 / self._half**2
            for column in columns:
                gain = out[:, None, column, :-1]
                at_steep, at_centre = slice(net * h, (net + 1) * h), slice((3 + net) * h, (4 + net) * h)
                values[..., column, at_centre] = gain * first
                values[..., column, at_steep] = gain * first * s
                seconds[..., column, at_centre] = gain * third * slope**2 * rate
                seconds[..., column, at_steep] = gain * (third * s * slope**2 + 2.0 * second * slope) * rate
                place = 6 * h + column * (h + 1)
                values[..., column, place : place + h] = hidden
                values[..., column, place + h] = 1.0
                seconds[..., column, place : place + h] = second * slope**2 * rate
        return values, seconds

    def columns(self) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
        """Return which column (vehicle by vehicle) belongs to each weight of the flat vector."""
        h, n, own = self.hidden, self.vehicles, self._own
        columns = np.arange(n * own).reshape(n, own)
        parts = (columns[:, : 3 * h], columns[:, 3 * h : 6 * h], columns[:, 6 * h :])
        return np.concatenate([part.ravel() for part in parts])
