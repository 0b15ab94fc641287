"""Simulated Crazyradio links: latency, loss, quantisation, and radios that vehicles share."""
