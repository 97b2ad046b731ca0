# SPDX-License-Identifier: Apache-2.0
"""A foreign Foxglove client: the protocol spoken by hand, messages decoded by the schemas that came with them."""

import asyncio
import base64
import json
import struct
import threading
from collections import defaultdict
from typing import Any

import websockets
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass

SUBPROTOCOL = "foxglove.sdk.v1"
NUMBER_CODES = {1: "u1", 2: "i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<f4", 8: "<f8"}


class Client:
    """Subscribes to every channel until `close`, and keeps it."""

    def __init__(self, port: int, assets: tuple[str, ...] = (), parameters: tuple[str, ...] = ()) -> None:
        self.messages: dict[str, list[Any]] = defaultdict(list)
        """Decoded, by topic."""
        self.channels: dict[str, dict[str, Any]] = {}
        self.server: dict[str, Any] = {}
        self.assets: dict[str, bytes | None] = {}
        self.parameters: dict[str, Any] = {}
        self.refused: list[str] = []
        self._port, self._wanted, self._asked = port, assets, parameters
        self._closing = False
        self._thread = threading.Thread(target=lambda: asyncio.run(self._listen()), daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._closing = True
        self._thread.join()

    async def _listen(self) -> None:
        address = f"ws://127.0.0.1:{self._port}"
        decoders: dict[int, Any] = {}
        async with websockets.connect(address, subprotocols=[SUBPROTOCOL], max_size=None) as socket:
            for number, uri in enumerate(self._wanted):
                await socket.send(json.dumps({"op": "fetchAsset", "uri": uri, "requestId": number}))
            if self._asked:
                await socket.send(json.dumps({"op": "getParameters", "parameterNames": self._asked, "id": "1"}))
            while not self._closing:
                try:
                    said = await asyncio.wait_for(socket.recv(), 0.1)
                except TimeoutError:
                    continue
                except websockets.ConnectionClosed:
                    return
                if isinstance(said, bytes):
                    self._take(said, decoders)
                    continue
                told = json.loads(said)
                if told["op"] == "serverInfo":
                    self.server = told
                elif told["op"] == "parameterValues":
                    self.parameters |= {one["name"]: one["value"] for one in told["parameters"]}
                elif told["op"] == "status":
                    self.refused.append(told["message"])
                elif told["op"] == "advertise":
                    for channel in told["channels"]:
                        self.channels[channel["topic"]] = channel
                        decoders[channel["id"]] = (channel["topic"], decoder_of(channel))
                        subscription = {"id": channel["id"], "channelId": channel["id"]}
                        await socket.send(json.dumps({"op": "subscribe", "subscriptions": [subscription]}))

    def _take(self, said: bytes, decoders: dict[int, Any]) -> None:
        if said[0] == 1:
            number, _ = struct.unpack_from("<IQ", said, 1)
            topic, decode = decoders[number]
            self.messages[topic].append(decode(said[13:]))
        elif said[0] == 4:
            number, status, error_length = struct.unpack_from("<IBI", said, 1)
            self.assets[self._wanted[number]] = None if status else said[10 + error_length :]


def decoder_of(channel: dict[str, Any]) -> Any:
    if channel["encoding"] == "json":
        return json.loads
    assert channel["encoding"] == "protobuf"
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(base64.b64decode(channel["schema"])).file:
        pool.Add(file)
    return GetMessageClass(pool.FindMessageTypeByName(channel["schemaName"])).FromString
