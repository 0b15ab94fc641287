"""What the bag of a flight holds: topics to record and to play, and the facts of its scenario."""
