"""Modules of the safety code that are mutated, and the tests that must notice."""

from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]


@dataclass(frozen=True, slots=True)
class MutatedModules:
    """Modules that are mutated, and the tests that must notice."""

    modules: tuple[str, ...]
    tests: tuple[str, ...]
    left_out: str = ""
    """Which tests are not run, in pytest's words: slow ones that others back up."""
    compiled: bool = False
    """Loops of other modules run compiled; the mutated ones call them, and are not called by them."""


def tests_of(package: str, *names: str) -> tuple[str, ...]:
    """Return the test files of these names in a package, by their paths in the repository."""
    found = [next((ROOT / "src" / package / "test").rglob(f"test_{name}.py")) for name in names]
    return tuple(str(one.relative_to(ROOT)) for one in found)


MUTATED = (
    MutatedModules(
        tuple(
            f"q2q_control.failsafe.{name}"
            for name in (
                "fallback_phases",
                "fallback_params",
                "stamp_delay",
                "stalled_stamps",
                "tracking_loss.elapsed_time",
                "tracking_loss.dead_reckoned_braking",
                "evasion.climb_back",
                "evasion.descent_evasion",
                "evasion.evasion_shift",
                "guard",
                "input_deadline",
            )
        ),
        tests_of(
            "q2q_control",
            "guard",
            "guard_clock",
            "guard_evasion",
            "guard_without_ticks",
            "input_deadline",
            "stamp_delay",
            "fallback_phases",
            "elapsed_time",
            "dead_reckoned_braking",
            "dead_reckoning",
            "climb_back",
            "descent_evasion",
            "evasion_end",
        ),
        "not mpc",
    ),
    MutatedModules(
        (
            "q2q_model.signals.clock_resets",
            *(
                f"q2q_model.estimation.{name}"
                for name in (
                    "association.jump_candidates",
                    "association.reacquisition",
                    "association.suspected_swaps",
                    "association.label_swaps",
                    "position.position_gates",
                    "attitude.attitude_steps",
                    "attitude.attitude_tracks",
                    "position.position_tracks",
                )
            ),
        ),
        tests_of(
            "q2q_model",
            "clock_resets",
            "tracking_gates",
            "position_gates",
            "position_tracks",
            "attitude_tracks",
            "mocap_filter",
            "mocap_filter_combined_faults",
            "mocap_names",
            "mocap_stamps",
        ),
    ),
    MutatedModules(
        tuple(
            f"q2q_planner.online.{name}"
            for name in (
                "safe.safe_replanner",
                "last_known_states",
                "safe.motion.committed_motion",
                "safe.motion.followed_reference",
                "safe.motion.motion_propagation",
                "safe.choice.decision",
                "safe.tracking_uncertainty",
                "safe.lost_vehicles",
                "safe.nonfinite_setpoints",
                "safe.motion.traffic",
                "safe.choice.desired_motion",
            )
        ),
        tests_of(
            "q2q_planner",
            "committed_motion",
            "traffic",
            "safe_tick",
            "safe_replanner",
            "nonfinite_setpoints",
            "jerk_limited_replanner",
            "encounters",
        ),
        compiled=True,
    ),
    MutatedModules(
        tuple(
            f"q2q_planner.online.safe.stopping.{name}" for name in ("jerk_limited", "jerk_limited_separation")
        ),
        ("src/q2q_planner/test/online/test_jerk_limited.py",),
        "not compiled_and_plain",
    ),
)
