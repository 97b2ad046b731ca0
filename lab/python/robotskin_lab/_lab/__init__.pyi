"""The compiled part of the laboratory: baselines, the fault campaign, single cells and units, traffic without cells."""

from robotskin_lab._lab import baselines as baselines
from robotskin_lab._lab import campaign as campaign
from robotskin_lab._lab import firmware as firmware
from robotskin_lab._lab import traffic as traffic
