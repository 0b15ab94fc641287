"""Copies of flights: windows of motion, digests, what is said of them."""
