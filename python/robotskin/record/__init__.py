"""Recording, replay and export."""
