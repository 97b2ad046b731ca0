# SPDX-License-Identifier: Apache-2.0
"""Benchmarks: one module a benchmark, flat JSON out."""
