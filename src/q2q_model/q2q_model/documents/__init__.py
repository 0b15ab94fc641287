"""Documents: YAML text, plain values, and frozen dataclasses made of them."""
