# SPDX-License-Identifier: Apache-2.0
"""Recordings in the forms of others: data sets of robot learning."""

from robotskin.export.lerobot import ExportFormatError, export_lerobot

__all__ = ["ExportFormatError", "export_lerobot"]
