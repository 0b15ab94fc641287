"""The receding horizon distilled into a small law for the vehicle's own processor (section 5.2)."""
