"""The one procedure by which real vehicles fly: from the ground to the ground."""
