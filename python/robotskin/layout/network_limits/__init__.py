# SPDX-License-Identifier: Apache-2.0
"""What the wiring of a skin can carry at the best: maximum flow, least depth, best trees, and where more would help."""

from robotskin.layout.network_limits.advice import Advice, best_bridge, best_cable
from robotskin.layout.network_limits.depth import hops_to_cables, least_depth_of_even_loads, least_depths
from robotskin.layout.network_limits.flow import Bottleneck, bottleneck
from robotskin.layout.network_limits.reading import ReadNetwork, named_networks, read_networks
from robotskin.layout.network_limits.report import sentences
from robotskin.layout.network_limits.trees import Forest, best_forest, least_fullest
from robotskin.layout.network_limits.verdict import PartVerdict, Verdict, judge

__all__ = [
    "Advice",
    "Bottleneck",
    "Forest",
    "PartVerdict",
    "ReadNetwork",
    "Verdict",
    "best_bridge",
    "best_cable",
    "best_forest",
    "bottleneck",
    "hops_to_cables",
    "judge",
    "least_depth_of_even_loads",
    "least_depths",
    "least_fullest",
    "named_networks",
    "read_networks",
    "sentences",
]
