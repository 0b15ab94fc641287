"""Zones that pairs must stay out of: by downwash, by risk."""
