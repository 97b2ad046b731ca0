# SPDX-License-Identifier: Apache-2.0
"""The self-configuration of a simulated robot, from its first movement to its report."""
