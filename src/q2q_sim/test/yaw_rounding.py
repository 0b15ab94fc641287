"""What the firmware's 32-bit floats leave of a yaw."""

YAW_32 = 2.4e-7
"""Last digit of a 32-bit float from 2 to 4: what wrapping leaves of a yaw [rad]."""
