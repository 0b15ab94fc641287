"""Node shell: parameters, tick wiring, readiness, diagnostics, process."""
