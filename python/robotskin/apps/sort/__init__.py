# SPDX-License-Identifier: Apache-2.0
"""A gripper squeezes fruits between its skinned pads, and sorts hard from soft ones (V-A, figure 12)."""
