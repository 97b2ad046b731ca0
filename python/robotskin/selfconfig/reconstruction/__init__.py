# SPDX-License-Identifier: Apache-2.0
"""Step 4: the shape of every patch from gravity and hinges, with its covariance."""
