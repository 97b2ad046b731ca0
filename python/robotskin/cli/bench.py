# SPDX-License-Identifier: Apache-2.0
"""Measure; each benchmark prints a table and writes flat JSON. Needs the checkout."""

from robotskin.laboratory import laboratory

app = laboratory("bench_command", "robotskin bench").app
