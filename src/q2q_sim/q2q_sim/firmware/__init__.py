"""Emulation of the Crazyflie firmware: commander, planner, supervisor, controllers, motors.

Written after bitcraze/crazyflie-firmware, commit 2a18fc2 (August 2026, protocol 12); "firmware: FILE" names
the source file below src/ of a number or a rule. No line of it is copied.

Quantities that clients see are in the firmware's units, given in their names: angles and rates in degrees,
thrust in PWM (0..65535). The firmware's pitch is the *legacy* one, nose up positive: minus theta of
q2q_model.geometry.rotations. Everything else is SI, world frame, z up.

| folder or file | content |
|---|---|
| commander/ | priorities of setpoints; take-off, landing, go-to, uploaded trajectories |
| controllers/ | Mellinger and the PID cascade, compiled, at 500 Hz; mixer |
| motors/ | airframe, battery, thrust curve |
| parameters/ | parameter table, values of one vehicle, uploads of clients |
| supervisor/ | arming, watchdogs, emergency stop |
| estimator | onboard position estimate |
| firmware_build, firmware_rows | options and decks of a vehicle; what it knows of its motion |
| firmware | everything above the controllers, for one vehicle, at 100 Hz |
| firmware_tick | 10 ms of flight of a swarm under its own controllers |
"""
