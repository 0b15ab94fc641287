"""The calls of cflib's eleven examples (crazyflie-lib-python, examples/, July 2026) run to the end.

| example | test |
|---|---|
| autonomy/autonomous_sequence, autonomous_sequence_high_level, motion_commander_demo | of a flight |
| step-by-step/sbs_motion_commander, sbs_swarm, sbs_connect_log_param | of a flight, of a parameter |
| logging/basiclog, basiclog_sync | of a log |
| parameters/basicparam, persistent_params, persistent_params_from_file | of parameters |

Tests of logs and parameters: test_crtp_example_parameters.
"""

from collections.abc import Callable
from threading import Event

import numpy as np
import pytest

pytest.importorskip("cflib", reason="cflib is not installed: requirements/dev.txt has it")

from cflib.crazyflie import Crazyflie
from cflib.crazyflie.mem import MemoryElement, Poly4D
from cflib.crazyflie.swarm import CachedCfFactory, Swarm
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.positioning.motion_commander import MotionCommander
from cflib.utils.reset_estimator import reset_estimator
from crtp_stage import ANSWER_S, SPOTS, Stage, log_of

OVERSHOOT = 0.12
"""Of the stock PID after a climb: its integral of the height lets go slowly [m]."""


def assert_landed_at(stage: Stage, x: float, y: float, vehicle: int = 0) -> None:
    stage.clock.sleep(1.0)
    np.testing.assert_allclose(stage.crazyflies.pos(vehicle), [x, y, 0.0], atol=0.1)
    assert not stage.crazyflies.firmware(vehicle).supervisor.tumbled


def arm(stage: Stage, cf: Crazyflie) -> None:
    cf.supervisor.send_arming_request(do_arm=True)
    stage.clock.sleep(1.0)


def test_a_sequence_of_positions_is_flown_by_position_setpoints(stage: Stage) -> None:
    corners = [(0.0, 0.0, 0.4), (0.0, 0.0, 1.2), (0.5, -0.5, 1.2), (-0.5, 0.5, 1.2), (0.0, 0.0, 0.4)]
    with stage.crazyflie() as scf:
        cf = scf.cf
        reset_estimator(scf)
        arm(stage, cf)
        for _ in range(10):
            cf.commander.send_velocity_world_setpoint(0, 0, 0.4, 0)
            stage.clock.sleep(0.1)
        for corner in corners:
            for _ in range(50):
                cf.commander.send_position_setpoint(*corner, 0)
                stage.clock.sleep(0.1)
            np.testing.assert_allclose(stage.crazyflies.pos(), corner, atol=OVERSHOOT)
        cf.commander.send_stop_setpoint()
        cf.commander.send_notify_setpoint_stop()
        stage.clock.sleep(0.1)
    assert_landed_at(stage, 0.0, 0.0)


def test_an_uploaded_trajectory_is_flown_between_take_off_and_landing(stage: Stage) -> None:
    with stage.crazyflie() as scf:
        cf = scf.cf
        memory = cf.mem.get_mems(MemoryElement.TYPE_TRAJ)[0]
        still = Poly4D.Poly()
        there = Poly4D.Poly([0.0, 0.0, 0.0, 10 / 8, -15 / 16, 6 / 32, 0.0, 0.0])  # 1 m in 2 s, rest to rest
        back = Poly4D.Poly([1.0, 0.0, 0.0, -10 / 8, 15 / 16, -6 / 32, 0.0, 0.0])
        memory.trajectory = [Poly4D(2.0, one, still, still, still) for one in (there, back)]
        assert memory.write_data_sync()
        cf.high_level_commander.define_trajectory(1, 0, 2)
        reset_estimator(cf)
        arm(stage, cf)
        cf.high_level_commander.takeoff(1.0, 2.0, yaw=0.0)
        stage.clock.sleep(3.0)
        cf.high_level_commander.start_trajectory(1, 1.0, relative_position=True, relative_yaw=False)
        stage.clock.sleep(2.0)
        np.testing.assert_allclose(stage.crazyflies.pos(), [1.0, 0.0, 1.0], atol=0.15)  # lags a little
        stage.clock.sleep(2.0)
        cf.high_level_commander.land(0.0, 2.0)
        stage.clock.sleep(2.0)
        cf.high_level_commander.stop()
    assert_landed_at(stage, 0.0, 0.0)


@pytest.mark.parametrize("stage", [(1, "deck"), (1, "flow")], indirect=True, ids=["deck", "flow"])
def test_a_motion_commander_moves_turns_circles_and_lands(stage: Stage) -> None:
    with stage.crazyflie() as scf:
        arm(stage, scf.cf)
        with MotionCommander(scf) as motion:
            stage.clock.sleep(1.0)
            assert stage.crazyflies.pos()[2] == pytest.approx(0.3, abs=0.05)
            motion.forward(0.8)
            assert stage.crazyflies.pos()[0] == pytest.approx(0.8, abs=0.15)
            motion.back(0.8)
            motion.up(0.5)
            motion.down(0.5)
            motion.right(0.5, velocity=0.8)
            stage.clock.sleep(1.0)
            assert stage.crazyflies.pos()[1] == pytest.approx(-0.5, abs=0.15)
            motion.left(0.5, velocity=0.4)
            motion.circle_right(0.5, velocity=0.5, angle_degrees=180)
            motion.turn_left(90)
            stage.clock.sleep(1.0)
            assert stage.crazyflies.firmware().rows.attitude_deg[2] == pytest.approx(-90.0, abs=10.0)
            motion.move_distance(-1, 0.0, 0.5, velocity=0.6)
            motion.start_left(velocity=0.5)
            stage.clock.sleep(1.0)
            motion.stop()
        stage.clock.sleep(1.0)
    assert stage.crazyflies.pos()[2] == pytest.approx(0.0, abs=0.02)
    assert not stage.crazyflies.firmware().supervisor.tumbled


@pytest.mark.parametrize("stage", [(1, "flow")], indirect=True, ids=["flow"])
def test_a_script_that_waits_for_a_flow_deck_finds_it_and_flies(stage: Stage) -> None:
    attached, seen = Event(), []
    with stage.crazyflie() as scf:
        scf.cf.param.add_update_callback(
            group="deck", name="bcFlow2", cb=lambda _, value: attached.set() if int(value) else None
        )
        assert attached.wait(ANSWER_S)
        place = log_of("Position", 10, ("stateEstimate.x", "stateEstimate.y"))
        scf.cf.log.add_config(place)
        place.data_received_cb.add_callback(lambda _, data, __: seen.append(data["stateEstimate.x"]))
        arm(stage, scf.cf)
        place.start()
        with MotionCommander(scf, default_height=0.5) as motion:
            stage.clock.sleep(1.0)
            motion.forward(0.5)
            motion.turn_left(180)
            motion.forward(0.5)
            stage.clock.sleep(1.0)
        place.stop()
    assert max(seen) == pytest.approx(0.5, abs=0.1)
    assert_landed_at(stage, 0.0, 0.0)


@pytest.mark.parametrize("stage", [(4, "deck")], indirect=True, ids=["four"])
def test_a_swarm_lights_up_resets_arms_takes_off_flies_its_sequences_and_lands(stage: Stage) -> None:
    clock, crazyflies = stage.clock, stage.crazyflies

    def fly(script: Callable[..., None], arguments: dict[str, list[object]] | None = None) -> None:
        with clock.parallel(len(stage.uris)):
            swarm.parallel_safe(script, args_dict=arguments)

    def light(scf: SyncCrazyflie) -> None:
        scf.cf.param.set_value("led.bitmask", 255)
        clock.sleep(2.0)
        scf.cf.param.set_value("led.bitmask", 0)
        clock.sleep(2.0)

    def take_off(scf: SyncCrazyflie) -> None:
        scf.cf.high_level_commander.takeoff(1.0, 2.0)
        clock.sleep(3.0)

    def sequence(scf: SyncCrazyflie, steps: list[tuple[float, float]]) -> None:
        for x, y in steps:
            scf.cf.high_level_commander.go_to(x, y, 0.0, 0, 3.0, relative=True)
            clock.sleep(3.0)

    def land(scf: SyncCrazyflie) -> None:
        scf.cf.high_level_commander.land(0.0, 2.0)
        clock.sleep(2.0)
        scf.cf.high_level_commander.stop()

    with Swarm(stage.uris, factory=CachedCfFactory(rw_cache=stage.cache)) as swarm:
        fly(light)
        with clock.parallel(len(stage.uris)):
            swarm.reset_estimators()
        fly(lambda scf: arm(stage, scf.cf))
        fly(take_off)
        assert [crazyflies.pos(k)[2] for k in range(4)] == pytest.approx([1.0] * 4, abs=OVERSHOOT)
        steps: list[object] = [[(-0.5, 0.5), (0.5, -0.5), (0.5, 0.0)]]
        fly(sequence, dict.fromkeys(stage.uris, steps))
        fly(land)
    for k, (x, y) in enumerate(SPOTS[:, :2]):
        assert_landed_at(stage, x + 0.5, y, k)
