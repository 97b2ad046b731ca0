# SPDX-License-Identifier: Apache-2.0
"""Stage 4: datagrams of section units to checked samples, liveness and statistics."""

from robotskin._core.driver import *  # noqa: F403
