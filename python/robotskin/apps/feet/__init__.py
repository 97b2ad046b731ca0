# SPDX-License-Identifier: Apache-2.0
"""An exoskeleton's soles feel the ground, and three motors on the arm tell its wearer (V-F, figure 17)."""
