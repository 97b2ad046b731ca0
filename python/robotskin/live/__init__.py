# SPDX-License-Identifier: Apache-2.0
"""Sessions and networks that run by themselves, on a thread of their own, for a page that looks in."""
