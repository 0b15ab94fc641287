"""Stand-in for Crazyswarm2's package `crazyflie_py` and its server, over the vehicles of a licence.

A program for Crazyswarm2 calls `crazyflie_py`, which asks a server by ROS, which speaks CRTP to the vehicles.
Here the calls make the server's packets themselves. Names and signatures are those of Crazyswarm2 (MIT
licence, commit f6154e2), the packets those of its library crazyflie_cpp; neither is part of q2q.

| file | content |
|---|---|
| served_vehicles | vehicles of the server, from a crazyflies.yaml |
| message_fields | arguments as fields of ROS messages, of the type that each needs; values of parameters |
| server_packets | packets of each command |
| server_links | links to the vehicles: one by one in order, or to all at once and unacknowledged |
| connection | what the server does when it connects: parameters, logs |
| reports | pose and status in the vehicles' logs |
| vehicle_calls | class Crazyflie |
| swarm_calls | class CrazyflieServer: commands to all vehicles |
| time_helper | class TimeHelper |
| operator_input | joystick and keyboard, on which a button is pressed after a while |
| uav_trajectory | piecewise polynomials from a CSV file |
| ellipsoids | module `util`: collisions of ellipsoids, positions at random |
| absent | what cannot be stood in for says so |
| modules | the modules in the place of `crazyflie_py` |
"""
