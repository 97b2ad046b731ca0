# SPDX-License-Identifier: Apache-2.0
"""Topics of ROS 2 on Cyclone DDS, without ROS: names and types as ROS mangles them, bytes as they are."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from cyclonedds.core import DDSException
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic
from cyclonedds.util import duration
from rosbags.interfaces import Nodetype

from robotskin.sharing.errors import SharingError
from robotskin.sharing.ros2_messages import Topic
from robotskin.sharing.ros2_types import typestore

PARTICIPANTS = 60
"""Of how many processes on this machine peers are looked for, where multicast is off."""
DEPTH = 50
"""Messages kept for a reader that is slow."""
DOMAIN_MAX = 232
NUMBERS = {
    "bool": bool, "int8": types.int8, "uint8": types.uint8, "byte": types.byte, "int16": types.int16,
    "uint16": types.uint16, "int32": types.int32, "uint32": types.uint32, "int64": types.int64, "uint64": types.uint64,
    "float32": types.float32, "float64": types.float64, "string": str,
}  # fmt: skip

LOOPBACK = """<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>{participants}</MaxAutoParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""
NETWORK = """<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="{interface}"/></Interfaces>
<AllowMulticast>true</AllowMulticast></General></Domain></CycloneDDS>"""


@cache
def idl_type(name: str) -> type[IdlStruct]:
    """A type of ROS 2 for DDS, made of its definition; an instance with `raw` is sent as these bytes."""
    package, kind, short = name.split("/")
    fields = {field: _idl_of(definition) for field, definition in typestore().fielddefs[name][1]}
    made = make_idl_struct(f"{short}_", f"{package}.{kind}.dds_.{short}_", fields)
    setattr(made, "serialize", _serialize)  # noqa: B010
    return made


def _serialize(sample: Any, **_: Any) -> bytes:
    raw: bytes = sample.raw
    return raw


def _idl_of(definition: Any) -> Any:
    kind, what = definition
    if kind == Nodetype.NAME:
        return idl_type(what)
    if kind == Nodetype.BASE:
        return NUMBERS[what[0]]
    inner, count = what
    of: Any = types
    return of.sequence[_idl_of(inner)] if kind == Nodetype.SEQUENCE else of.array[_idl_of(inner), count]


class DdsNode:
    """A participant: on the loopback without multicast, or on a network interface with it, if one is named.

    Raises:
        SharingError: no such domain or interface.
    """

    def __init__(self, domain: int, interface: str | None = None) -> None:
        if not 0 <= domain <= DOMAIN_MAX:
            raise SharingError(f"--ros2 {domain}: domains are 0 to {DOMAIN_MAX}")
        if interface is None:
            text = LOOPBACK.format(participants=PARTICIPANTS)
        elif re.fullmatch(r"[\w.:-]{1,32}", interface):
            text = NETWORK.format(interface=interface)
        else:
            raise SharingError(f"--ros2-interface {interface}: no name of a network interface")
        try:
            self._domain = Domain(domain, text)
            self._participant = DomainParticipant(domain)
        except DDSException as error:
            where = "127.0.0.1" if interface is None else f"interface {interface}"
            raise SharingError(f"--ros2 {domain}: no DDS on {where}: {error}") from error

    def writer(self, topic: Topic) -> RawWriter:
        """Of a topic; reliable, and latched where the topic is."""
        return RawWriter(self._participant, topic)

    def reader(self, topic: Topic) -> DataReader:
        """Of a topic, whose samples come as objects with the fields of the message."""
        kept = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(DEPTH))
        return DataReader(self._participant, _dds_topic(self._participant, topic), kept)


def _dds_topic(participant: DomainParticipant, topic: Topic) -> DdsTopic:
    return DdsTopic(participant, f"rt{topic.name}", idl_type(topic.type_name))


class RawWriter:
    """Sends messages of one topic that are bytes already."""

    def __init__(self, participant: DomainParticipant, topic: Topic) -> None:
        durability = Policy.Durability.TransientLocal if topic.latched else Policy.Durability.Volatile
        kept = Qos(
            Policy.Reliability.Reliable(duration(seconds=1)),
            Policy.History.KeepLast(1 if topic.latched else DEPTH),
            durability,
            Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
        )
        self._sample = object.__new__(idl_type(topic.type_name))
        self._writer = DataWriter(participant, _dds_topic(participant, topic), kept)

    def send(self, raw: bytes) -> None:
        """A message in CDR, with its header of four bytes."""
        self._sample.raw = raw  # type: ignore[attr-defined]
        self._writer.write(self._sample)

    @property
    def readers(self) -> int:
        """How many listen."""
        return len(self._writer.get_matched_subscriptions())
