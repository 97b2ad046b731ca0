# SPDX-License-Identifier: Apache-2.0
"""Topics of ROS 2 on DDS, without ROS, and the port of a robot whose joints they tell and command.

What imports `dds` or `message_types` needs the extra `ros2`.
"""

from robotskin.ros2.errors import Ros2Error
from robotskin.ros2.topic import Topic

__all__ = ["Ros2Error", "Topic"]
