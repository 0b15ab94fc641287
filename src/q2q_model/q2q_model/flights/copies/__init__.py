"""Detection of duplicate flights: windows of motion, digests, and the words of the report."""
