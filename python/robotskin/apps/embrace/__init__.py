# SPDX-License-Identifier: Apache-2.0
"""A humanoid takes a person in its arms and gives way to them, and draws large things to its chest."""
