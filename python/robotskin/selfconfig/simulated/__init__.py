# SPDX-License-Identifier: Apache-2.0
"""What ideal robots in imperfect skins would feel and show: data for benches and tests."""
