# SPDX-License-Identifier: Apache-2.0
"""Laws here are about what happens, not how fast the machine is: no deadline an example."""

from hypothesis import settings

settings.register_profile("no deadline", deadline=None)
settings.load_profile("no deadline")
