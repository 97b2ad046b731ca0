"""Benchmarks: one module a benchmark, flat JSON out."""
