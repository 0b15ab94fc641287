"""Where positions or plans were not recorded, nothing is judged, and the verdict says so."""

from dataclasses import replace

import numpy as np
from judged_hover import AROUND, HOVER, TICKS, flown, moved, output

from q2q_model.flights.flight import of_rows
from q2q_sim.monitors.flight_judgement import verdict_of


def test_what_was_not_recorded_is_not_judged_and_reported() -> None:
    nowhere = np.full_like(HOVER, np.nan)
    no_plan = output(flown(ref_pos=nowhere))
    unjudged = "floor and setpoint_error (no reference recorded)"
    assert no_plan == f"ok: 10.0 s flown to the end; not judged: {unjudged}"
    assert "floor, setpoint_error and distances" in output(flown(true_pos=nowhere))
    assert "missed ticks" in output(flown(status=np.full((TICKS, 2), np.nan)))


def test_a_vehicle_without_positions_for_a_while_is_not_judged_then() -> None:
    nan = (np.nan, np.nan, np.nan)
    message = "ok: 10.0 s flown to the end; not judged: cf2 from 3.0 to 8.0 s (no position recorded)"
    assert output(flown(moved(3.0, 8.0, 1, nan))) == message
    assert output(flown(moved(9.0, 20.0, 0, nan))).endswith("cf1 from 9.0 to 10.0 s (no position recorded)")
    assert output(flown(moved(3.0, 3.4, 1, nan))) == "ok: 10.0 s flown to the end"


def test_the_filtered_positions_are_judged_where_nobody_knows_the_truth() -> None:
    recorded = flown(true_pos=np.full_like(HOVER, np.nan))
    fallen = replace(recorded, pos=moved(5.6, 5.8, 1, (0.0, 1.0, 0.0)))
    assert output(fallen) == "cf2 hit the floor at 5.6 s"


def test_positions_that_nothing_measured_are_called_estimates() -> None:
    estimated = replace(flown(true_pos=np.full_like(HOVER, np.nan)), pos=HOVER)
    whether = "measurements (no sample of motion capture recorded: positions are estimates)"
    assert output(estimated) == f"ok: 10.0 s flown to the end; not judged: {whether}"
    sample = np.full_like(HOVER, np.nan)
    sample[:10] = HOVER[:10]
    assert whether not in output(replace(estimated, mocap_pos=sample))
    part, whole = of_rows(estimated, slice(100, None)), replace(estimated, mocap_pos=sample)
    assert whether not in str(verdict_of(part, AROUND, whole=whole))


def test_a_vehicle_that_was_never_seen_yet_is_nowhere_and_not_on_the_floor() -> None:
    """The filter puts it at the origin, here below cf1."""
    unknown = flown(true_pos=np.full_like(HOVER, np.nan))
    late = replace(unknown, pos=moved(0.0, 0.8, 1, (0.0, 0.0, 0.0)))
    seen = replace(late, mocap_pos=moved(0.0, 0.8, 1, (np.nan, np.nan, np.nan)))
    assert output(seen) == (
        "ok: 10.0 s flown to the end; not judged: cf2 from 0.0 to 0.8 s (no position recorded)"
    )
    fallen = replace(seen, pos=moved(5.6, 5.8, 1, (0.0, 1.0, 0.0)))
    assert output(fallen).startswith("cf2 hit the floor at 5.6 s")


def test_a_lost_vehicle_is_not_where_it_was_last() -> None:
    """The filter holds its position, here at its setpoint, whatever becomes of it."""
    unknown = flown(true_pos=np.full_like(HOVER, np.nan))
    lost = replace(unknown, pos=HOVER, mocap_pos=moved(4.0, 10.0, 1, (np.nan, np.nan, np.nan)))
    said = output(lost)
    assert said.startswith("ok: 10.0 s flown to the end; not judged: cf2 from 4.3 to 10.0 s")
