# SPDX-License-Identifier: Apache-2.0
"""What the pages say, measured again: runs of benches kept as small files, and the table that is made from them.

In: `catalogue.toml`, which names the runs and the rows. Out: `docs/results/RUN.json`, one file a run with its commit,
seeds and machine, and the table of docs/reproduction.md.
"""
