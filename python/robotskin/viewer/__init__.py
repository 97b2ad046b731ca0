# SPDX-License-Identifier: Apache-2.0
"""The browser page that shows robot, skin and network."""
