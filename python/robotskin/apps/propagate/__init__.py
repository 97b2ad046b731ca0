# SPDX-License-Identifier: Apache-2.0
"""A mobile robot with two arms gives way with its base where an arm cannot (V-E, figure 16)."""
