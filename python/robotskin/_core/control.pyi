"""Stage 7: tasks, fusion and the torque resolver."""
