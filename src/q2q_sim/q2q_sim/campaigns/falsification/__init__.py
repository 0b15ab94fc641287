"""Falsification, in guided campaigns: a search of the faults that leave the policies the least margin.

    search (seed) -> runs with faults from a vector -> margins -> CMA-ES -> violation -> shrunk -> case file

A search is its seed and its number of runs: the same search on any machine. Seeded bugs measure what the
search can find compared with blind drawing.
"""
