"""Robustness: controllers that correct the downwash under wrong assumptions, against uncompensated ones."""
