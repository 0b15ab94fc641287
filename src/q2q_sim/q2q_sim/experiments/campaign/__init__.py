"""Fly random faults through random scenarios, and judge every flight by the safety policies.

    seed -> draw (scenario document, controller, faults) -> flight (closed_loop, or nodes) -> policies ->
    Outcome

A run is its seed: the same seed draws the same flight on any machine.
"""
