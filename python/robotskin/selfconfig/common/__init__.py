# SPDX-License-Identifier: Apache-2.0
"""What several steps use: gravity, what is known beforehand, small turns, work side by side."""
