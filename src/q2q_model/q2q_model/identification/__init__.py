"""Identification: from recorded flights to gains, an interference zone and an interaction model."""
