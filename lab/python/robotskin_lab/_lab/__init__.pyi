"""
The compiled part of the laboratory: baselines, the fault campaign, traffic without cells.
"""

from robotskin_lab._lab import baselines as baselines, campaign as campaign, traffic as traffic
