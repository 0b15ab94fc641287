"""What is changed in a scenario by dataclasses.replace is flown in every air."""

from dataclasses import replace

import pytest

from q2q_model.vehicle.constants import CRAZYFLIE_2_1, on_firmware
from q2q_sim.faults.faults import Fault
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_variants import in_another_air, with_air, with_choices

OUTLIER = Fault(kind="outlier", start=1.0, duration=0.1, vehicles=("cf1",), size=1.0)


def _changed(scenario: Scenario) -> Scenario:
    return replace(scenario, duration=3.0, faults=(OUTLIER,), attitude="firmware")


@pytest.mark.parametrize("name", ["table6_room", "stack3"])
def test_changes_hold_in_another_air(name: str) -> None:
    own = library.load(name)
    written = with_air(own, "room", ())
    flown = with_air(_changed(own), "room", ())
    assert flown == _changed(written)
    assert flown != written


def test_a_change_of_a_chosen_vehicle_holds_in_another_air() -> None:
    chosen = with_choices(library.load("table6_room"), "crazyflie_2_1", "")
    flown = with_air(replace(chosen, duration=3.0), "room", ())
    assert flown.vehicle == on_firmware(CRAZYFLIE_2_1, "stock_2025_02")
    assert flown.duration == 3.0


def test_overrides_that_the_other_air_does_not_change_hold_there() -> None:
    own = library.load("stack3")
    changed = replace(own, overrides={"pid": {"k_p_z": 7.0}})
    assert with_air(changed, "room", ()).overrides == {"pid": {"k_p_z": 7.0}}


def test_what_both_the_user_and_the_other_air_change_is_refused() -> None:
    own = library.load("table6_room")
    heavy = replace(own.vehicle, mass=own.vehicle.mass * 1.1)
    changed = replace(own, overrides={}, vehicle=heavy)
    with pytest.raises(ValueError, match=r"table6_room: vehicle, overrides .* name the air first"):
        with_air(changed, "room", ())
    assert with_air(changed, "paper", ()) == replace(changed, air="paper")  # its own wake: no other air
    assert own.in_air is not None
    same = replace(own, overrides=own.in_air.overrides)
    assert in_another_air(same) == own.in_air
