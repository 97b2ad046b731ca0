# SPDX-License-Identifier: Apache-2.0
"""Recordings in the forms of others: data sets of robot learning, bags of ROS 2, files of Foxglove and Rerun."""

from robotskin.export.errors import ExportFormatError
from robotskin.export.lerobot import export_lerobot

__all__ = ["ExportFormatError", "export_lerobot"]
