# SPDX-License-Identifier: Apache-2.0
"""Teaching by touch (V-A): a gripper's skills, what is seen of a demonstration, rules and plans learnt from it."""
