# SPDX-License-Identifier: Apache-2.0
"""Runs the same work with many seeds: in this process, in several, or on a Ray cluster.

In: a function of a module, and jobs with a key each, such as a seed. Out: (key, result) as the jobs end. Where a job
runs makes no difference to its result, and a worker that dies costs only the jobs it had, which are run again.
"""

from robotskin_lab.executors.executor import Executor, JobLostError, in_order
from robotskin_lab.executors.here import Here
from robotskin_lab.executors.named import ExecutorNameError, named
from robotskin_lab.executors.processes import Processes
from robotskin_lab.executors.ray_cluster import RayCluster, RayMissingError

__all__ = [
    "Executor",
    "ExecutorNameError",
    "Here",
    "JobLostError",
    "Processes",
    "RayCluster",
    "RayMissingError",
    "in_order",
    "named",
]
