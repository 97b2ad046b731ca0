# SPDX-License-Identifier: Apache-2.0
"""Topics of ROS 2 on Cyclone DDS, without ROS: names and types as ROS mangles them, bytes as they are."""

from __future__ import annotations

import re
import socket
from functools import cache
from typing import Any
from weakref import WeakValueDictionary

from cyclonedds.core import DDSException, InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct, types
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic
from cyclonedds.util import duration
from rosbags.interfaces import Nodetype

from robotskin.ros2.errors import Ros2Error
from robotskin.ros2.message_types import typestore
from robotskin.ros2.topic import Topic

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
def idl_type(name: str, raw: bool = False) -> type[IdlStruct]:
    """A type of ROS 2 for DDS, made of its definition; an instance with `raw` is sent as these bytes.

    raw: what is heard is kept in `raw` as it came, not taken apart.
    """
    package, kind, short = name.split("/")
    fields = {field: _idl_of(definition) for field, definition in typestore().fielddefs[name][1]}
    made = make_idl_struct(f"{short}_", f"{package}.{kind}.dds_.{short}_", fields)
    setattr(made, "serialize", _serialize)  # noqa: B010
    if raw:
        setattr(made, "deserialize", classmethod(_kept))  # noqa: B010
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


def _kept(cls: type[IdlStruct], data: bytes, **_: Any) -> Any:
    sample = object.__new__(cls)
    sample.raw = bytes(data)  # type: ignore[attr-defined]
    return sample


class _OpenDomain(Domain):
    """A domain of this process, and where it is."""

    text = ""


_open_domains: WeakValueDictionary[int, _OpenDomain] = WeakValueDictionary()


def _domain(number: int, text: str) -> Domain:
    """DDS has a domain once in a process: all nodes of the same number share it. Raises Ros2Error, DDSException."""
    held = _open_domains.get(number)
    if held is None:
        held = _open_domains[number] = _OpenDomain(number, text)
        held.text = text
    elif held.text != text:
        raise Ros2Error(f"ROS 2 domain {number}: this program has it on another interface already; give both the same")
    return held


class DdsNode:
    """A participant: on the loopback without multicast, or on a network interface with it, if one is named.

    Raises:
        Ros2Error: no such domain or interface.
    """

    def __init__(self, domain: int, interface: str | None = None) -> None:
        if not 0 <= domain <= DOMAIN_MAX:
            raise Ros2Error(f"ROS 2 domain {domain}: domains are 0 to {DOMAIN_MAX}")
        if interface is None:
            text = LOOPBACK.format(participants=PARTICIPANTS)
        elif re.fullmatch(r"[\w.:-]{1,32}", interface):
            text = NETWORK.format(interface=interface)
        else:
            raise Ros2Error(f"ROS 2 interface {interface}: no name of a network interface")
        try:
            self._domain = _domain(domain, text)
            self._participant = DomainParticipant(domain)
        except DDSException as error:
            where = "127.0.0.1" if interface is None else f"interface {interface}"
            there = ", ".join(name for _, name in socket.if_nameindex())
            raise Ros2Error(
                f"ROS 2 domain {domain}: no DDS on {where}; this machine has the interfaces {there}"
            ) from error

    def writer(self, topic: Topic, depth: int = DEPTH, waits_s: float = 1.0) -> RawWriter:
        """Of a topic; reliable, and latched where the topic is; `waits_s`: at most for a reader that is slow."""
        return RawWriter(self._participant, topic, depth, waits_s)

    def close(self) -> None:
        """Leave the domain, once its writers and readers are gone."""
        del self._participant, self._domain

    def raw_reader(self, topic: Topic) -> RawReader:
        """Of a topic, whose messages are wanted as bytes; also of a talker that repeats nothing."""
        return RawReader(self._participant, topic)

    def reader(self, topic: Topic) -> DataReader:
        """Of a topic, whose samples come as objects with the fields of the message."""
        kept = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(DEPTH))
        return DataReader(self._participant, _dds_topic(self._participant, topic), kept)


def _dds_topic(participant: DomainParticipant, topic: Topic) -> DdsTopic:
    return DdsTopic(participant, f"rt{topic.name}", idl_type(topic.type_name))


class RawWriter:
    """Sends messages of one topic that are bytes already."""

    def __init__(self, participant: DomainParticipant, topic: Topic, depth: int, waits_s: float) -> None:
        durability = Policy.Durability.TransientLocal if topic.latched else Policy.Durability.Volatile
        kept = Qos(
            Policy.Reliability.Reliable(duration(seconds=waits_s)),
            Policy.History.KeepLast(1 if topic.latched else depth),
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


class RawReader:
    """Hears messages of one topic as bytes."""

    def __init__(self, participant: DomainParticipant, topic: Topic) -> None:
        kept = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(DEPTH))
        raw = DdsTopic(participant, f"rt{topic.name}", idl_type(topic.type_name, raw=True))
        self._reader = DataReader(participant, raw, kept)
        self._some = WaitSet(participant)
        self._unread = ReadCondition(self._reader, SampleState.NotRead | ViewState.Any | InstanceState.Any)
        self._some.attach(self._unread)

    def take(self) -> list[bytes]:
        """What came, in CDR with its header, the oldest first."""
        return [one.raw for one in self._reader.take(N=DEPTH) if hasattr(one, "raw")]

    def close(self) -> None:
        """Hear no more."""
        del self._some, self._unread, self._reader

    def wait(self, seconds: float) -> None:
        """Until something came, at longest so long."""
        self._some.wait(duration(seconds=seconds))

    @property
    def talkers(self) -> int:
        """How many tell it."""
        return len(self._reader.get_matched_publications())
