"""The safe replanner's promise about vehicles: a tube of tracking error, and encounters that test both.

seed -> encounter -> flight with full dynamics -> largest tracking errors, smallest distances -> tube, verdict
"""
