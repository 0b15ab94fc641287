"""Bags of other software, read by a topic map."""
