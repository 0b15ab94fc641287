"""Flights through the real nodes: start, wire, fly, watch, end, measure."""
