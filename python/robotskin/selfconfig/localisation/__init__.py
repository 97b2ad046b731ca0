# SPDX-License-Identifier: Apache-2.0
"""Step 6: link and place of every patch, from motion or from pictures of its LEDs."""
