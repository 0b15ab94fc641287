"""Rules of a licence: limits, and when they are broken, by one vehicle, by two, or by the program."""
