"""Step 7: masses and friction from joint torques."""
