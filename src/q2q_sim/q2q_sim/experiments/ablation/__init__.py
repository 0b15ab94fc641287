"""Compare controllers that know the downwash with ones that do not."""
