"""Flight licence: programs flown unmodified against emulated vehicles, without and with faults, and judged.

A program runs in a process of its own, which also flies the vehicles. Its clock is that of the room: time
passes only while all of its threads wait, so that a verdict does not depend on the speed of the machine.

| file | content |
|---|---|
| program_process/cooperative_scheduler | threads of a program one at a time, and their clock |
| program_process/patched_threading | sleeping, clocks, locks and threads of Python by this scheduler |
| program_process/simulator_errors | errors of the simulator itself, which are not the program's |
| program_process/link_host | where the links of a program end |
| program_process/emulated_link | link driver for cflib that ends at the vehicles |
| crazyflie_py | stand-in for Crazyswarm2's crazyflie_py and its server |
| room/licence_room | vehicles, their motion capture and faults, with the log of a flight |
| client_commands | commands in the packets of a program, in words; plans that no vehicle can follow |
| room/licence_log | log of a flight as arrays, commands and the end of the program |
| flight_order | program to fly, and how |
| program_flight | one flight of a program |
| room/trials | flights of a licence, and the faults in them |
| fault_trials | trials with a fault, at times from the flight without faults |
| rules/ | what a flight must not do, what it did first, and why: the command or the silence before it |
| licence_options | conditions of a licence |
| trial_processes | flights in processes of their own, judged |
| licence_flights | all flights of a program |
| licence_reports | verdict as text, JSON, JUnit XML and page |
| licence_score | programs with and without seeded bugs |
| licence_command | what the command line flies, reports and writes |
"""
