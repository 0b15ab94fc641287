"""The radio path: controller, radio pilot, cflib's encoders, link model, CRTP endpoint, firmware.

Section 5.2's flight (50 s, Q2 passes over Q1) in simulated time, and by the direct link of the same room.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from numpy.polynomial import Polynomial

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from cflib.crazyflie.commander import Commander
from cflib.crazyflie.high_level_commander import HighLevelCommander
from cflib.crazyflie.localization import Localization
from cflib.crazyflie.supervisor import Supervisor

from cflib_fleet import STILL, Wire
from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link.rpyt_scale import RpytScale
from q2q_control.radio.link.setpoints import full_states, level_rpyt, rpyt_setpoints
from q2q_control.radio.link.vehicle_link import CflibSender, LinkHealth
from q2q_control.radio.pilot.pilot_params import RadioPilotParams
from q2q_control.radio.pilot.radio_pilot import RadioPilot
from q2q_control.radio.pilot.vehicle_record import Phase
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array
from q2q_model.trajectory.polynomials import setpoint_at
from q2q_model.vehicle.thrust_map import BRUSHED_MOTOR, PWM_FULL
from q2q_sim.crtp.fleet_room import CrtpRoomParams, fleet_in
from q2q_sim.crtp.packets.packet import is_stream
from q2q_sim.firmware.firmware import Firmware
from q2q_sim.firmware.motors.battery import CURVE_CHARGE, CURVE_VOLT, HOVER_TIME
from q2q_sim.firmware.motors.thrust_curve import CURVE
from q2q_sim.link.shared_radios import DelayLine, SharedRadioParams, SharedRadios
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.loop.flight_blocks import BlockChoices, Mode, blocks_of
from q2q_sim.loop.room import Room
from q2q_sim.monitors.metrics.flight_metrics import measure
from q2q_sim.scenarios import library
from q2q_sim.scenarios.scenario import Scenario

MELLINGER = 2
BOOT_TICKS = 50
"""The firmware arms itself within these."""


@dataclass(frozen=True)
class _Link(CflibSender):
    """Add a vehicle's own word on its health to cflib's encoders."""

    firmware: Firmware

    def health(self) -> LinkHealth:
        return LinkHealth(
            connected=True, volt=self.firmware.battery.volt, armed=self.firmware.supervisor.armed
        )


class _RadioPath:
    """Room whose vehicles are flown by radio."""

    def __init__(self, scenario: Scenario, seed: int, positioning: str) -> None:
        self.room = Room(scenario, seed)
        self.fleet = fleet_in(self.room, scenario, CrtpRoomParams(start="air", positioning=positioning))
        late, loss = scenario.radio.latency + scenario.vicon.latency, scenario.radio.loss
        self._radios = SharedRadios(SharedRadioParams(latency=late, loss=loss), len(scenario.names), seed)
        self._air: DelayLine[tuple[int, bytes]] = DelayLine()
        still = np.tile(STILL, (len(scenario.names), 1))
        for _ in range(BOOT_TICKS):
            self.fleet.fly(still)

    def link(self, row: int) -> _Link:
        def offer(datagram: bytes) -> list[bytes]:
            arrival = self._radios.arrival(row, self.room.tick * TICK_S, streamed=is_stream(datagram))
            if arrival is not None:
                self._air.push(arrival, (row, datagram))
            return []

        wire = Wire(offer)
        return _Link(
            Commander(wire), HighLevelCommander(wire), Localization(wire), Supervisor(wire),
            self.fleet.vehicles[row].firmware,
        )  # fmt: skip

    def advance(self) -> None:
        for row, datagram in self._air.due(self.room.tick * TICK_S + 1e-9):
            self.fleet.vehicles[row].handle(datagram)
        self.room.fly(self.fleet.fly)


def flown(scenario: Scenario, mode: Mode, by: str, positioning: str = "deck", seed: int = 0) -> Array:
    """Return every vehicle's height error [m], (T, n), of a flight by RPYT setpoint or by full state."""
    model = find_model(scenario.model).interaction
    blocks = blocks_of(scenario, BlockChoices(mode), model)
    path = _RadioPath(scenario, seed, positioning)
    names, scale = scenario.names, RpytScale(scenario.vehicle.full_pwm_thrust)
    pilot = RadioPilot(
        {name: path.link(k) for k, name in enumerate(names)},
        RadioPilotParams(),
        level_rpyt(scenario.vehicle.hover_thrust, scale) if by == "rpyt" else None,
    )
    for vehicle in path.fleet.vehicles:
        vehicle.firmware.parameters.set("stabilizer.controller", MELLINGER if by == "full state" else 1)
    errors = []
    for k in range(round(scenario.duration / TICK_S)):
        tick = path.room.capture()
        t = tick.frame.t
        state = blocks.mocap_filter.update(tick.frame)
        downwash = blocks.predictor.update(state)
        expected = setpoint_at(blocks.plan, t)
        aware = downwash if mode != "ignoring" else None
        pilot.watch(t)
        pilot.update_state(state, t)
        if k == 1:  # the filter trusts no first sample
            for act in (Act.ARM, Act.STREAM):
                pilot.begin(Order(act), t)
                pilot.watch(t)
        if by == "rpyt":
            command = blocks.controller.update(state, expected, aware)
            pilot.fly_rpyt(names, rpyt_setpoints(command, scale), t)
        else:
            pilot.fly_full_states(names, full_states(expected, aware), t)
        errors.append(tick.truth.pos[:, 2] - expected.pos[:, 2])
        path.advance()
    assert set(pilot.phases.values()) == {Phase.FLYING}
    return np.array(errors)


def _rms(errors: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(errors**2, axis=0)))


@cache
def _room() -> Scenario:
    """Return the flight up to 5 s after the passage: what follows is the loop's own swing."""
    return replace(library.load("table6_room"), duration=30.0)


def _direct(mode: Mode, scenario: Scenario | None = None) -> Array:
    room = scenario or _room()
    options = FlightOptions(mode=mode, model=find_model(room.model).interaction)
    rows = measure(fly(room, options), room.vehicle).vehicles.values()
    return np.array([one.z_rmse_m for one in rows])


def _compensated_share(thrust_share: float) -> float:
    """Return the share of a wanted thrust that the firmware's battery compensation gives at hover.

    The supply it reckons with follows the battery with time constant tau, so is late by tau |dV/dt|, and it
    drops half a PWM of the duty on average. With T the curve of a motor's thrust over its voltage u:

        share = 1 - u T'(u) / T(u) (tau |dV/dt| / V + 1 / (2 duty)),   duty = 65535 u / V
    """
    curve = Polynomial(CURVE)
    roots = (curve - thrust_share * BRUSHED_MOTOR).roots()
    u = float(roots[np.isreal(roots)].real.max())
    volt = float(CURVE_VOLT[-2:].mean())  # 30 s from full stay in the first tenth of the charge
    slope = float(np.diff(CURVE_VOLT[-2:])[0] / (np.diff(CURVE_CHARGE[-2:])[0] * HOVER_TIME))
    late = -1e-3 / np.log(0.99) * slope  # the low-pass takes 1 % each ms
    lost = late / volt + 0.5 * volt / (PWM_FULL * u)
    return 1.0 - u * float(curve.deriv()(u) / curve(u)) * lost


def test_rpyt_setpoints_over_the_air_fly_the_room_as_the_direct_link_does() -> None:
    """The direct link flies the same room with the thrust that the firmware's battery compensation loses.

    What the link explains besides: rounding to PWM stands for 0.2 mm (0.1 mN on 0.65 kg over K_p 0.81), the
    tick for 10 ms more of delay, in which nothing climbs by more than 0.2 mm.
    """
    vehicle = _room().vehicle
    share = _compensated_share(vehicle.hover_thrust / vehicle.full_pwm_thrust)
    less = replace(_room().disturbance, thrust_gain_min=share, thrust_gain_max=share)
    over_the_air = _rms(flown(_room(), "aware", "rpyt"))
    direct = _direct("aware", replace(_room(), disturbance=less))
    assert direct[0] > 0.02
    np.testing.assert_allclose(over_the_air, direct, atol=4e-4)


def test_acc_less_eta_on_mellingers_loop_cuts_the_error_as_the_aware_pid_does() -> None:
    """Places come from the filter over the same link: no vehicle knows its own."""
    ignoring, aware = (_rms(flown(_room(), mode, "full state", "external")) for mode in ("ignoring", "aware"))
    by_pid = _direct("aware")[0] / _direct("ignoring")[0]
    assert ignoring[0] > 0.003  # 0.392 m/s^2 over 37 /s^2, for the seconds of the passage
    assert aware[0] / ignoring[0] < by_pid
    assert aware[0] < 5e-4  # VICON's noise through the filter


def test_a_lone_marker_reaches_the_vehicle_as_a_position_without_attitude() -> None:
    path = _RadioPath(_room(), 0, "external")
    link, firmware = path.link(0), path.fleet.vehicles[0].firmware
    before, turn = np.array(firmware.external.quat), (0.0, 0.0, 0.6, 0.8)

    def fed(quat: tuple[float, ...] | None) -> Array:
        link.send_external_pose((1.0, 2.0, 3.0), quat)
        for _ in range(10):
            path.advance()
        return np.array(firmware.external.quat)

    np.testing.assert_array_equal(fed(None), before)
    np.testing.assert_allclose(firmware.external.pos, (1.0, 2.0, 3.0), atol=1e-6)
    np.testing.assert_allclose(fed(turn), turn, atol=1e-2)  # compressed to 32 bit
