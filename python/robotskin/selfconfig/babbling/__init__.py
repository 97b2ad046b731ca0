# SPDX-License-Identifier: Apache-2.0
"""Step 2: where and how the robot moves so that its cells feel most, safely."""
