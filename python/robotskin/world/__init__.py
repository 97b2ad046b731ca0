# SPDX-License-Identifier: Apache-2.0
"""The simulated two ends of the flow: cells' network and links in virtual time, and the robot's body in MuJoCo.

In: a layout, a robot, a seed; pushes, joint commands, datagrams of the host. Out: datagrams of the section units, joint
states. Physics every millisecond, frames in between. It runs the shipping firmware; only clock, wires and body are
simulated. What can go wrong: a layout whose links the robot lacks, a cell that does not exist (typed errors).
"""

from robotskin.simulator import HandTask, Imperfections, InProcess, LineQuality, ServoGains, UdpTransport
from robotskin.world.hand import Hand
from robotskin.world.ideal import ideal_world
from robotskin.world.scene import HandSpec
from robotskin.world.scene_files import SceneError, load_scene, read_scene, scene_names
from robotskin.world.thing import Thing
from robotskin.world.things import SceneSpec, ThingSpec
from robotskin.world.trial import run_trial
from robotskin.world.world import World, WorldError

__all__ = [
    "Hand",
    "HandSpec",
    "HandTask",
    "Imperfections",
    "InProcess",
    "LineQuality",
    "SceneError",
    "SceneSpec",
    "ServoGains",
    "Thing",
    "ThingSpec",
    "UdpTransport",
    "World",
    "WorldError",
    "ideal_world",
    "load_scene",
    "read_scene",
    "run_trial",
    "scene_names",
]
