# SPDX-License-Identifier: Apache-2.0
"""A hand with four fingers takes a ball or a cylinder without pushing it over (V-B, figure 13)."""
