# SPDX-License-Identifier: Apache-2.0
"""A robot is led by its skin, watches what it is led to do, and makes rules and a plan of it (V-A, figure 12)."""
