"""Comparison of the emulated firmware with tables of the real one's answers.

A table is a list of rows, column name to text; a case is the rows of one run after a reboot.

| file | table | tested part |
|---|---|---|
| table_rows | | rows by case; numbers of a row |
| controller_table | controllers.csv | one step of a controller for each row |
| planner_table | planner.csv | the high-level commander, packet by packet, at 100 Hz |
| supervisor_table | supervisor.csv | the supervisor, packet by packet, with motors |
| motor_tables | mixer.csv, compensation.csv | mixer and battery compensation |
| tolerances | | all of it, each difference with its tolerance |
"""
