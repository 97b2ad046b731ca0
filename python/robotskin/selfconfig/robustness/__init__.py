# SPDX-License-Identifier: Apache-2.0
"""After a configuration: what has changed is noticed, named and alone made new."""
