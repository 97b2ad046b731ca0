"""
The compiled core of robotskin: one submodule for each stage of the flow.
"""

from robotskin._core import (
    control as control,
    driver as driver,
    firmware as firmware,
    loop as loop,
    model as model,
    record as record,
    robot as robot,
    skin as skin,
    world as world,
)
