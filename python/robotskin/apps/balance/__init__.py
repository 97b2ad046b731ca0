# SPDX-License-Identifier: Apache-2.0
"""A humanoid stands, gives way where it is touched, leans against those who push, and does not fall.

Section V-D of the paper, on Talos with 1260 cells (docs/standing.md).
"""
