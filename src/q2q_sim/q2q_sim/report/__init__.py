"""Figures, tables and HTML pages of flights."""
