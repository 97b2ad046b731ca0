"""The compiled core of robotskin: one submodule for each stage of the flow."""

from robotskin._core import model as model
from robotskin._core import firmware as firmware
from robotskin._core import driver as driver
from robotskin._core import skin as skin
from robotskin._core import record as record
from robotskin._core import health as health
from robotskin._core import control as control
from robotskin._core import robot as robot
from robotskin._core import loop as loop
from robotskin._core import ur as ur
from robotskin._core import serial as serial
from robotskin._core import world as world
