"""
The compiled part of the laboratory: baselines, the fault campaign, single cells and units, traffic without cells.
"""

from robotskin_lab._lab import baselines as baselines, campaign as campaign, firmware as firmware, traffic as traffic
