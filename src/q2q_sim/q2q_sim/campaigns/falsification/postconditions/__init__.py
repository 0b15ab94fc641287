"""Postconditions of filter, guard and safe replanner, checked on the ticks of a run.

signals of a run -> RunTicks -> postcondition(run, ticks) -> PostconditionOutcome (violations, margin)
"""
