"""Where the cells are: covering link meshes, layout files, their checks and pictures."""
