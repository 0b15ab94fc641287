"""App for the firmware of a vehicle, in C99: predicts the downwash of its neighbours and corrects it."""
