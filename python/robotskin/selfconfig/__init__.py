"""Stage 6: from the running skin to a skin model."""
