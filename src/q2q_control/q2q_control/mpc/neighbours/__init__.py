"""Vehicles of other controllers: the predictions that MPCs exchange, or constant velocity."""
