"""Step 1: neighbour reports to patches, roots and paths."""
