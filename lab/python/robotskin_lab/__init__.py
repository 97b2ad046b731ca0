# SPDX-License-Identifier: Apache-2.0
"""The laboratory: what measures and tests robotskin. It belongs to the checkout, and no wheel holds it."""
