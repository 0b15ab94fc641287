"""Campaigns: many simulated flights with random or guided faults, judged by policies."""
