"""Tests `phalanx run --live` with clients of the Foxglove WebSocket protocol on the loopback interface.

Protocol: https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md (text frames are JSON; a binary frame
with opcode 1 is a message: subscription, time in ns, bytes; with opcode 2 the time of the server).
"""

import base64
import json
import signal
import socket
import struct
import subprocess
import time
import unittest
from urllib.parse import urlparse

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.reader import make_reader
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

import logs

TIMEOUT_S = 30


class Server:
    """A running `phalanx run --live`."""

    def __init__(self, scene, *options, address="127.0.0.1:0"):
        command = [logs.PHALANX, "run", logs.SCENES / scene, "--live", address, *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        first = self.process.stderr.readline()
        self.url = next((word for word in first.split() if word.startswith("ws://")), None)
        if self.url is None:
            self.process.kill()
            raise RuntimeError(first + self.process.communicate()[1])

    def wait_for_line(self, text):
        """Waits for a line on stderr that contains `text`."""
        for line in self.process.stderr:
            if text in line:
                return
        raise RuntimeError(f"the server has not printed {text!r}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def finish(self):
        """Waits for the end; returns standard output, standard error and status."""
        out, err = self.process.communicate(timeout=TIMEOUT_S)
        return out, err, self.process.returncode


class Client:
    """A client that subscribes to all channels."""

    def __init__(self, test, url, **options):
        options = {"compression": None, "max_size": None, "close_timeout": 1, **options}
        self.socket = test.enterContext(connect(url, subprotocols=["foxglove.sdk.v1"], **options))
        self.info = self._text("serverInfo")
        self.channels = {}
        self.messages = {}
        self.times = []
        self.status = []

    def _text(self, op):
        """Returns the next text frame with the operation `op`; discards other frames."""
        while True:
            frame = self.socket.recv(timeout=TIMEOUT_S)
            if isinstance(frame, str) and json.loads(frame)["op"] == op:
                return json.loads(frame)

    def subscribe(self, count):
        """Subscribes to all channels once `count` channels are advertised."""
        while len(self.channels) < count:
            for channel in self._text("advertise")["channels"]:
                self.channels[channel["id"]] = channel
        subscriptions = [{"id": number, "channelId": number} for number in self.channels]
        self.messages = {channel["topic"]: [] for channel in self.channels.values()}
        self.socket.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))

    def read(self, enough=lambda client: False):
        """Reads until `enough(self)` or until the connection is closed."""
        try:
            while not enough(self):
                frame = self.socket.recv(timeout=TIMEOUT_S)
                if isinstance(frame, str):
                    self.status.append(json.loads(frame))
                elif frame[0] == 1:
                    number, time_ns = struct.unpack_from("<IQ", frame, 1)
                    self.messages[self.channels[number]["topic"]].append((time_ns, frame[13:]))
                elif frame[0] == 2:
                    self.times.append(struct.unpack_from("<Q", frame, 1)[0])
        except ConnectionClosed:
            pass

    @property
    def count(self):
        return sum(map(len, self.messages.values()))


def recorded(path):
    """Returns the schemas and the undecoded messages of a log, by topic."""
    with open(path, "rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        messages = {channel.topic: [] for channel in summary.channels.values()}
        schemas = {c.topic: summary.schemas[c.schema_id] for c in summary.channels.values()}
        for _, channel, message in reader.iter_messages(log_time_order=False):
            messages[channel.topic].append((message.log_time, message.data))
    return schemas, messages


class Live(unittest.TestCase):
    def test_a_client_receives_the_log_despite_stalled_and_lost_clients(self):
        # More messages than the system buffers for a connection, so that a client that does not read blocks.
        scene = logs.DIRECTORY / "many.toml"
        scene.write_text((logs.SCENES / "experiment-95.toml").read_text() + '\n[log]\nnumeric_rate = "500 kHz"\n')
        quiet = logs.run(scene)
        schemas, messages = recorded(quiet.path)
        log = logs.DIRECTORY / "live.mcap"
        options = ["--live-wait", "--live-speed", "0.01", "--log", log, "--json"]
        with Server(scene, *options) as server:
            stalled = Client(self, server.url, sock=slow_socket(server.url), max_queue=1)
            leaver = Client(self, server.url)
            client = Client(self, server.url)
            # All three subscribe before the run starts: it waits for the first subscription and then for 0.3 s without another.
            for each in (client, leaver, stalled):
                each.subscribe(len(schemas))
            start = time.monotonic()
            leaver.read(lambda client: client.count > 200)
            # Disconnects without a closing handshake.
            leaver.socket.socket.shutdown(socket.SHUT_RDWR)
            client.read(lambda client: client.count == sum(map(len, messages.values())))
            took_s = time.monotonic() - start
            client.read()
            out, _, status = server.finish()
        self.assertEqual(status, 0)
        # The stalled client received fewer messages, so it did block.
        stalled.read()
        self.assertLess(stalled.count, client.count)
        self.assertEqual(client.info["name"], "phalanx: experiment-95")
        self.assertIn("time", client.info["capabilities"])

        self.assertEqual(client.messages, messages)
        for channel in client.channels.values():
            schema = schemas[channel["topic"]]
            self.assertEqual(channel["encoding"], "protobuf")
            self.assertEqual((channel["schemaName"], channel["schemaEncoding"]), (schema.name, "protobuf"))
            self.assertEqual(base64.b64decode(channel["schema"]), schema.data)
            FileDescriptorSet.FromString(schema.data)
        # The client that left had received the first messages.
        self.assertGreater(leaver.count, 200)
        for topic, seen in leaver.messages.items():
            self.assertEqual(seen, messages[topic][: len(seen)])

        # The announced time is the simulation time; the run took 2 s of wall-clock time.
        self.assertEqual(client.times, sorted(client.times))
        self.assertEqual(client.times[-1], 20_000_000)
        self.assertGreater(len([time for time in client.times if 0 < time < 20_000_000]), 20)
        output = json.loads(out)
        self.assertGreater(took_s, 1.9)
        # A live run has the same results and the same log.
        self.assertEqual({**output, "wall_s": 0, "log": ""}, {**quiet.json, "wall_s": 0, "log": ""})
        self.assertEqual(log.read_bytes(), quiet.path.read_bytes())

    def test_a_late_client_gets_the_latest_message_of_every_topic(self):
        _, messages = recorded(logs.run("experiment-95.toml").path)
        with Server("experiment-95.toml", "--live-speed", "1e6", "--live-keep") as server:
            server.wait_for_line("the run is over")
            client = Client(self, server.url)
            client.subscribe(len(messages))
            expected = {topic: sent[-1:] for topic, sent in messages.items()}
            client.read(lambda client: client.count == sum(map(len, expected.values())) and client.times)
            self.assertEqual(client.messages, expected)
            self.assertEqual(set(client.times), {20_000_000})
            server.process.send_signal(signal.SIGINT)
            # No further message arrives.
            client.read()
            self.assertEqual(client.messages, expected)
            _, _, status = server.finish()
        self.assertEqual(status, 0)

    def test_discs_and_the_engine(self):
        for scene, *options in [("laws/impact.toml",), ("experiment-95.toml", "--model", "engine")]:
            with self.subTest(scene, options=options):
                _, messages = recorded(logs.run(scene, *options).path)
                with Server(scene, "--live-wait", "--live-speed", "0.1", *options) as server:
                    client = Client(self, server.url)
                    client.subscribe(len(messages))
                    client.read(lambda client: client.count == sum(map(len, messages.values())))
                    client.socket.close()
                    self.assertEqual(server.finish()[2], 0)
                self.assertEqual(client.messages, messages)

    def test_interrupt_while_waiting_for_a_client(self):
        with Server("experiment-95.toml", "--live-wait") as server:
            server.wait_for_line("waits for a client")
            server.process.send_signal(signal.SIGINT)
            _, err, status = server.finish()
        self.assertEqual(status, 3)
        self.assertIn("interrupted by SIGINT", err)

    def test_addresses_that_cannot_be_served(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            address = "127.0.0.1:%d" % taken.getsockname()[1]
            cases = [(address, "another program listens there"), ("8765", "not ADDRESS:PORT"), ("127.0.0.1:x", "not ADDRESS:PORT")]
            cases.append(("192.0.2.1:8765", "give an address of this machine"))
            for address, words in cases:
                with self.subTest(address):
                    command = [logs.PHALANX, "run", logs.SCENES / "experiment-95.toml", "--live", address]
                    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S)
                    self.assertEqual((done.returncode, done.stdout), (2, ""))
                    self.assertIn(words, done.stderr)


def slow_socket(url):
    """Returns a connection with a small buffer, so that a stalled reader blocks the server early."""
    address = urlparse(url)
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.connect((address.hostname, address.port))
    return connection


if __name__ == "__main__":
    unittest.main()
