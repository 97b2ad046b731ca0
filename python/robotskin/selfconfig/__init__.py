# SPDX-License-Identifier: Apache-2.0
"""Stage 6: from the running skin to a skin model."""
