"""Vehicle side of the Crazyflie Real Time Protocol, version 12.

Pure: bytes in, bytes out, time from the room. Sources: bitcraze/crazyflie-firmware, commit 2a18fc2
("firmware: FILE" is below its src/), and cflib 0.1.34, whose encoders the tests compare every packet with. No
line of either is copied.

| port | content | file |
|---|---|---|
| 0 console | messages of the vehicle | vehicle |
| 2 parameters | table, read, write, by name, EEPROM | param_toc, parameters, parameters_misc |
| 3 RPYT | roll, pitch, yaw rate, thrust | commander_rpyt |
| 4 memory | the trajectory memory | memory |
| 5 logging | table, blocks | log_toc, log_blocks |
| 6 localization | external position and pose | localization |
| 7 generic setpoints | full state, position, velocity, hover, ... | commander_generic, cppm_setpoint |
| 8 high-level commander | take-off, land, go-to, spiral, trajectories | commander_high_level |
| 9 supervisor | state, arming, recovery, emergency stop | supervisor_port |
| 13 platform | protocol and firmware version, arming (old) | platform |
| 15 link | echo, source | link_service |

vehicle serves all ports, fleet and fleet_room fly the vehicles, link.shared_radios delays and loses packets.
"""
