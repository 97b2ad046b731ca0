# SPDX-License-Identifier: Apache-2.0
"""Scripted runs of a session: what is done to the robot, and the figures that must hold."""
