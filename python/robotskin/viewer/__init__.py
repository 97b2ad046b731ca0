"""The browser page that shows robot, skin and network."""
