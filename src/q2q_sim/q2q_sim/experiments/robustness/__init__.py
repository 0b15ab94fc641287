"""Robustness: corrected controllers that believe something wrong, against the same controllers ignoring."""
