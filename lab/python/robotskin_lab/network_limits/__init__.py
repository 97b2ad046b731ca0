# SPDX-License-Identifier: Apache-2.0
"""Proofs of what no forest of a depth can do better: exact, and slow, beside the quick bounds of the product."""

from robotskin_lab.network_limits.bounded_depth import LoadWithin, least_depth_of_load, least_load_within, load_within
from robotskin_lab.network_limits.branch_and_bound import Decision, decide

__all__ = ["Decision", "LoadWithin", "decide", "least_depth_of_load", "least_load_within", "load_within"]
