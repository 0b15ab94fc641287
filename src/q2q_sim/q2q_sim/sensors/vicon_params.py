"""Parameters of motion capture: its noise, and the rates and lengths of its effects on frames.

Rates and sizes are those that Crazyswarm users report (docs and issue trackers); VICON's static noise is
0.15 mm.
"""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable
from q2q_sim.sensors.episodes import Frequency


@dataclass(frozen=True, slots=True)
class ViconParams:
    """Noise, dropout and outliers of motion capture; the defaults are perfect."""

    latency: float = tunable(
        0.0, "delay from exposure to the frame at the computer", unit="s", low=0.0, high=0.5
    )
    pos_noise: float = tunable(0.0, "standard deviation of measured positions", unit="m", low=0.0, high=0.1)
    angle_noise: float = tunable(
        0.0, "standard deviation of measured attitudes", unit="rad", low=0.0, high=0.5
    )
    outlier_rate: float = tunable(0.0, "rate of outliers per vehicle", unit="1/s", low=0.0, high=100.0)
    outlier_min: float = tunable(0.2, "smallest outlier", unit="m", low=0.0, high=100.0)
    outlier_max: float = tunable(2.0, "largest outlier", unit="m", low=0.0, high=100.0)
    dropout_rate: float = tunable(0.0, "rate of dropouts per vehicle", unit="1/s", low=0.0, high=10.0)
    dropout_min: float = tunable(0.1, "shortest dropout", unit="s", low=0.0, high=10.0)
    dropout_max: float = tunable(0.3, "longest dropout", unit="s", low=0.0, high=10.0)
    missing_rate: float = tunable(0.0, "rate of long absences per vehicle", unit="1/s", low=0.0, high=10.0)
    missing_min: float = tunable(1.0, "shortest long absence", unit="s", low=0.0, high=100.0)
    missing_max: float = tunable(3.0, "longest long absence", unit="s", low=0.0, high=100.0)
    flip_rate: float = tunable(0.0, "rate of axis flips per vehicle", unit="1/s", low=0.0, high=10.0)
    flip_max: float = tunable(0.05, "longest axis flip", unit="s", low=0.0, high=10.0)
    swap_rate: float = tunable(0.0, "rate of marker swaps per vehicle", unit="1/s", low=0.0, high=10.0)
    swap_max: float = tunable(0.1, "longest marker swap", unit="s", low=0.0, high=10.0)
    stale_rate: float = tunable(0.0, "rate of bursts of stale frames", unit="1/s", low=0.0, high=10.0)
    stale_max: float = tunable(0.1, "longest stale burst", unit="s", low=0.0, high=10.0)

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)
        for name in ("outlier", "dropout", "missing"):
            low, high = (getattr(self, f"{name}_{end}") for end in ("min", "max"))
            if low > high:
                raise ValueError(f"ViconParams.{name}_min = {low} is above {name}_max = {high}")


def frequencies(params: ViconParams) -> dict[str, Frequency]:
    """Return how often and for how long each effect on frames occurs, by its name."""
    return {
        "flip": Frequency(params.flip_rate, 0.0, params.flip_max),
        "swap": Frequency(params.swap_rate, 0.0, params.swap_max),
        "outlier": Frequency(params.outlier_rate),
        "stale": Frequency(params.stale_rate, 0.0, params.stale_max),
        "dropout": Frequency(params.dropout_rate, params.dropout_min, params.dropout_max),
        "missing": Frequency(params.missing_rate, params.missing_min, params.missing_max),
    }
