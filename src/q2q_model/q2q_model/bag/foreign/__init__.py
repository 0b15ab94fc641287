"""Bags of other software, read with a topic map."""
