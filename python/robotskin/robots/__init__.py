"""Stage 0: robots by URDF or by name, as one Pinocchio and one MuJoCo model that agree."""
