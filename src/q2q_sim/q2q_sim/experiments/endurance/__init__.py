"""Long flights through nodes, with measurements of memory, handles, bag and clock."""
