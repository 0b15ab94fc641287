"""Choice of a motion for every vehicle: the desired one, candidates, the proven choice, what is committed."""
