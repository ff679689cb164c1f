"""The verification manual: benchmarks with a reference that the program did not make."""
