"""A skinned robot in one object: driver, skin and controller, with a simulated world at both ends."""

from robotskin.session.session import INTERFACES, MODES, PERIOD_S, SOURCES, Session, SessionError

__all__ = ["INTERFACES", "MODES", "PERIOD_S", "SOURCES", "Session", "SessionError"]
