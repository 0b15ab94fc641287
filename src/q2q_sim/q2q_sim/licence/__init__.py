"""Flight licence: test flights of unmodified programs with emulated vehicles, with and without faults.

A program runs in a process of its own, which also flies the vehicles. Its clock is that of the room: time
passes only while all of its threads wait, so that a verdict does not depend on the speed of the machine.

| file | content |
|---|---|
| program_process/cooperative_scheduler | threads of a program one at a time, and their clock |
| program_process/patched_threading | sleeping, clocks, locks and threads of Python by this scheduler |
| program_process/simulator_errors | errors of the simulator itself, which are not the program's |
| program_process/link_host | vehicles' end of the program's links |
| program_process/emulated_link | link driver for cflib to the emulated vehicles |
| crazyflie_py | substitute for Crazyswarm2's crazyflie_py and its server |
| room/licence_room | vehicles, their motion capture and faults, with the log of a flight |
| client_commands | commands in the packets of a program, in words; plans that no vehicle can follow |
| room/licence_log | log of a flight as arrays, commands and the end of the program |
| flight_order | program to fly, with its options and fault |
| program_flight | one flight of a program |
| room/trials | flights of a licence, and the faults in them |
| fault_trials | trials with a fault, at times from the flight without faults |
| rules/ | rules of a flight, the first that is broken, and the cause: the last command, or missing commands |
| licence_options | conditions of a licence |
| trial_processes | flights in processes of their own, judged |
| licence_flights | all flights of a program |
| licence_reports | verdict as text, JSON, JUnit XML and page |
| licence_score | programs with and without seeded bugs |
| licence_command | flights, reports and files of the command line |
"""
