# SPDX-License-Identifier: Apache-2.0
"""Applications built from the stages."""
