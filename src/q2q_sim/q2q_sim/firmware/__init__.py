"""Fly one vehicle as the Crazyflie's firmware does: commander, planner, supervisor, controllers, motors.

Written after bitcraze/crazyflie-firmware, commit 2a18fc2 (August 2026, protocol 12); "firmware: FILE" names
the file below src/ that a number or a rule comes from. No line of it is copied.

Units are the firmware's where a client sees them, and the name says so: angles and rates in degrees, thrust
in PWM (0..65535). Pitch of the firmware is the *legacy* one, nose up positive: minus theta of
q2q_model.geometry.rotations. Everything else is SI, world frame, z up.

| file | what |
|---|---|
| setpoint | what a controller is asked for, axis by axis |
| parameter_table, parameters | names, types, numbers with their sources; the values of one vehicle |
| airframe | motors and inertia: what a PWM does |
| commander, planner, polynomial | who may command; take-off, land, go-to, uploaded trajectories |
| yaw_turn | the shorter way between two yaws, in 32 bits |
| supervisor_rules, supervisor, supervisor_info | arming, watchdogs, emergency stop; its bits |
| estimator, battery | what the vehicle believes of its position and its battery |
| uploads | trajectories and stored parameters of clients |
| thrust_curve, motors, whole | duty and force of a motor; numbers stored without fraction |
| columns, mellinger, pid_step, position_pid, attitude_pid, flight | the compiled 500 Hz loop |
| controller_choice | which controller flies, and what a new one forgets |
| firmware | all of it, for one vehicle, 100 times a second |
"""
