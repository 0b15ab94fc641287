"""Simulated Crazyradio link: latency, loss, quantisation."""
