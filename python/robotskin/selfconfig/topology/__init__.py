# SPDX-License-Identifier: Apache-2.0
"""Step 1: neighbour reports to patches, roots and paths."""
