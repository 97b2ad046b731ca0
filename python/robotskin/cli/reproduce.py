# SPDX-License-Identifier: Apache-2.0
"""Measure the figures of the pages again, and write the table that is made from them. Needs the checkout."""

from robotskin.laboratory import laboratory

command = laboratory("reproduce_command", "robotskin reproduce").command
