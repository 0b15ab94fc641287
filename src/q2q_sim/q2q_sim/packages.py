"""Packages of q2q with nodes, kernels and shipped data: each imports only those before it."""

PACKAGES = ("q2q_model", "q2q_planner", "q2q_control", "q2q_sim")
