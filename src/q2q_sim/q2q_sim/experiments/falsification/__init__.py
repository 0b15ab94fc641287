"""Falsification, in guided campaigns: a search of the faults that leave the policies the least margin.

    attack (seed) -> runs with faults from a vector -> margins -> CMA-ES -> violation -> shrunk -> case file

An attack is its seed and its number of runs: the same attack on any machine. Seeded bugs measure what the
search can find compared with blind drawing.
"""
