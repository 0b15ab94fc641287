"""Association of the samples that the tracks of their own names reject."""
