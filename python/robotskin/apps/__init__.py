"""Applications built from the stages."""
