# SPDX-License-Identifier: Apache-2.0
"""Step 5: which joint moves which cell, and joint axes and cells from the skin alone."""
