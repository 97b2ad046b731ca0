"""Step 8: the postural sensory-motor map."""
