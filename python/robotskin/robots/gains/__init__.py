"""Gains of the robots this project knows: one documented file a robot, and the reader of such files."""

from robotskin.robots.gains.gain_set import ChosenGains, GainError, GainSet, robots_with_gains

__all__ = ["ChosenGains", "GainError", "GainSet", "robots_with_gains"]
