"""Limits with which no flight can be completed safely are refused."""

from dataclasses import replace

import pytest

from q2q_control.flight_procedure.procedure_params import FlightProcedureParams

PARAMS = FlightProcedureParams()


def test_no_rest_may_be_so_short_that_motors_stop_in_the_fall() -> None:
    with pytest.raises(ValueError, match=r"settle_s = 0\.4; must be in \[0\.5, 10\.0\] s"):
        replace(PARAMS, settle_s=0.4)


def test_no_ground_may_be_so_near_that_noise_keeps_vehicles_from_it() -> None:
    """Of 100 vehicles with a noise of 3 mm, one was always beyond 1 cm."""
    with pytest.raises(ValueError, match=r"near_ground = 0\.02; must be in \[0\.03, 0\.5\] m"):
        replace(PARAMS, near_ground=0.02)


@pytest.mark.parametrize(("settle_s", "step_timeout_s"), [(6.0, 5.0), (1.0, 1.0), (1.0, 0.8)])
def test_no_rest_may_last_as_long_as_the_time_allowed_for_it(settle_s: float, step_timeout_s: float) -> None:
    """Every transit failed, and take-offs with 6 of 5 s."""
    allowed = (
        rf"settle_s = {settle_s:g}; must be less than step_timeout_s = {step_timeout_s:g} s, or no transit"
    )
    with pytest.raises(ValueError, match=allowed):
        replace(PARAMS, settle_s=settle_s, step_timeout_s=step_timeout_s)


def test_a_room_without_an_inside_is_refused() -> None:
    with pytest.raises(ValueError, match="lowest x, y, z and highest x, y, z"):
        FlightProcedureParams(room=(0.0, 0.0, 0.0, 1.0, 1.0, 0.0))


@pytest.mark.parametrize("wall", range(6))
def test_a_room_beyond_the_setpoints_that_vehicles_receive_is_refused(wall: int) -> None:
    """Clipped to their range, setpoints of two vehicles would be the same."""
    room = [-32.767, -32.767, -32.767, 32.767, 32.767, 32.767]
    FlightProcedureParams(room=tuple(room))
    room[wall] *= 1.001
    with pytest.raises(ValueError, match=r"room = .*: setpoints reach up to 32\.767 m .* move the origin"):
        FlightProcedureParams(room=tuple(room))


def test_a_take_off_through_the_ceiling_is_refused() -> None:
    low = (-3.0, -3.0, 0.0, 3.0, 3.0, 1.5)
    FlightProcedureParams(room=low, take_off_height=1.2, ground_height=0.3)
    with pytest.raises(ValueError, match=r"take_off_height = 1\.25; must be at most 1\.2 m"):
        FlightProcedureParams(room=low, take_off_height=1.25, ground_height=0.3)


@pytest.mark.parametrize(("ceiling", "ground_height"), [(0.6, -0.3), (0.7, 0.2), (1.2, 0.1)])
def test_a_take_off_up_to_the_ceiling_is_allowed_whatever_the_rounding(
    ceiling: float, ground_height: float
) -> None:
    room, height = (-3.0, -3.0, -2.0, 3.0, 3.0, ceiling), round(ceiling - ground_height, 1)
    assert (
        FlightProcedureParams(room=room, take_off_height=height, ground_height=ground_height).take_off_height
        == height
    )
