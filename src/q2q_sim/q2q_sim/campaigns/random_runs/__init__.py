"""Campaign: random faults in random scenarios, with every flight checked against the safety policies.

    seed -> draw (scenario document, controller, faults) -> flight (closed_loop, or nodes) -> policies ->
    Outcome

A run is defined by its seed: the same seed draws the same flight on any machine.
"""
