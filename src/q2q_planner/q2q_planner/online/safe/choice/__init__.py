"""Choice of a motion for every vehicle: candidates, the proven choice, and what is then committed."""
