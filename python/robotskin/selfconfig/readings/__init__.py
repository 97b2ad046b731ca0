# SPDX-License-Identifier: Apache-2.0
"""Step 3: what the cells felt, reduced without loss, and what a cell on a known link would feel."""
