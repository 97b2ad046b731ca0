"""The simulated two ends of the skin: links and faults, body and touch."""
