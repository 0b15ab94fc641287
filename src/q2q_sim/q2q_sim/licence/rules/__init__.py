"""Rules of a licence: limits, what breaks one and when, of one vehicle, of two, of the program."""
