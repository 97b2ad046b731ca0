# SPDX-License-Identifier: Apache-2.0
"""Step 8: the postural sensory-motor map."""
