"""References that nothing in flight imports."""
