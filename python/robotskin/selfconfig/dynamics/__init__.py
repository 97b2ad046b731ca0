# SPDX-License-Identifier: Apache-2.0
"""Step 7: masses and friction from joint torques."""
