"""Validation of an air: recorded flights flown again in the simulator and compared with themselves.

| module | content |
|---|---|
| recorded/tracked_flight | references, states and commands of a recorded flight, on an even grid |
| recorded/recorded_law | the recorded vehicles' own control law, read from their commands |
| recorded/force_regression | its gains, by regression |
| recorded/rotor_drag | drag of the rotors, read from accelerometers |
| recorded/estimate_noise | noise of the recorded estimate, by its spectrum |
| redrawn_flight | the flight flown again under that law, many draws of the air at once |
| error_spectrum | spectra of the height error in bands |
| flight_alone | one vehicle flown again along its setpoints by the emulated firmware |
| comparison | numbers that compare simulated with recorded height errors |
"""
