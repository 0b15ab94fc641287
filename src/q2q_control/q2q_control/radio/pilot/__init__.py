"""Procedure of a real vehicle over its link: orders, phases and automatic actions."""
