"""Compare the emulated firmware with tables of what the real one answers.

A table is a list of rows, column name to text; a case is the rows of one run from a fresh start.

| file | table | what runs |
|---|---|---|
| cases | | rows by case; numbers of a row |
| controllers | controllers.csv | one step of a controller a row |
| planner | planner.csv | the high-level commander, packet by packet, 100 times a second |
| supervisor | supervisor.csv | the supervisor, packet by packet, with motors |
| motors | mixer.csv, compensation.csv | mixer and battery compensation |
| verdict | | all of it, each figure beside its tolerance |
"""
