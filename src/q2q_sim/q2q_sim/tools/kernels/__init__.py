"""Machine code of all kernels, made at set-up."""
