"""Packages of q2q with nodes, kernels and shipped data.

They are in the order of import, each after those it imports, in which the survey of nodes and compile_kernels
go through them. The cache of the paper's experiments hashes their code and data.
"""

PACKAGES = ("q2q_model", "q2q_planner", "q2q_control", "q2q_sim")
