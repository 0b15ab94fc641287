"""CRTP ports: one file for each service of the protocol."""
