"""Properties that filter, guard and safe replanner state of their own output, checked on the ticks of a run.

signals of a run -> RunTicks -> property(run, ticks) -> StatedOutcome (violations, margin)
"""
