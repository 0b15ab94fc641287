"""Machine code of kernels: what it depends on, where it is stored, and the notice that it is made."""
