"""Zone of the safe replanner that Figs 12 and 13 show, apart from drawing, which is slow to import."""

from q2q_model.geometry.zone import Zone
from q2q_model.tunable import OutOfBoundsError
from q2q_planner.offline.certificate.convex_zone import zone_around
from q2q_planner.online.safe.motion.safe_replanner_params import SafeReplannerParams


def check_drawn(zone: Zone) -> None:
    """Raise ValueError if the replanner of Figs 12 and 13 cannot avoid the zone."""
    try:
        params_of_zone(zone)
    except OutOfBoundsError as wrong:
        shown = f"Figs 12 and 13 show the safe replanner, whose zone has {wrong.name} = {wrong.rest}"
        raise ValueError(f"--figures: {shown}; change the zone, or leave --figures out") from wrong


def params_of_zone(zone: Zone) -> SafeReplannerParams:
    """Return the parameters of a safe replanner with the zone's radius and half height.

    Raises:
        OutOfBoundsError: the safe replanner does not avoid zones of this size.
    """
    hull = zone_around(zone)
    return SafeReplannerParams(eps=hull.eps, d=hull.d, tracking=0.0)
