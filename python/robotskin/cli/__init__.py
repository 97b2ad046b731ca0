"""The robotskin command."""
