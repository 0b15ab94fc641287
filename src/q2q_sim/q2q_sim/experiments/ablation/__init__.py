"""Compare controllers that know the draft with ones that do not."""
