"""Stage 8: limits, watchdog and the last check before the robot."""
