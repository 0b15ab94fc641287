"""Laws that nothing in flight imports."""
