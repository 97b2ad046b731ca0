# SPDX-License-Identifier: Apache-2.0
"""Linear algebra on one thread: matrices of a patch are small, and threads that wait for each other only burn time."""

from __future__ import annotations

from threadpoolctl import threadpool_limits

one_thread = threadpool_limits.wrap(limits=1, user_api="blas")
"""Decorator: while the function runs, no BLAS call of this process uses more than one thread."""
