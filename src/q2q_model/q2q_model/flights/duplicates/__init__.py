"""Flights given twice: windows of motion, digests, what is said of them."""
