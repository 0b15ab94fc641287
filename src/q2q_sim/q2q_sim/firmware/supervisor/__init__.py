"""The firmware's supervisor: arming, watchdogs, emergency stop."""
