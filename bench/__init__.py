"""Benchmarks and comparisons: programs that print rows of JSON. Run them from the root, `python -m bench.NAME`."""
