"""Runs phalanx and decodes its logs with public Python packages only."""

import functools
import json
import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

PROJECT = Path(__file__).resolve().parents[2]
SCENES = PROJECT / "scenes"
PHALANX = os.environ.get("PHALANX", str(PROJECT / "target/debug/phalanx"))

_directory = tempfile.TemporaryDirectory(prefix="phalanx-clients-")
DIRECTORY = Path(_directory.name)


JOINTS = ["11", "21", "12", "22"]
JOINT_TOPICS = [f"/joint/q{index}" for index in JOINTS]


def state(joints):
    """The coordinates of a finger from the messages of its joints: angles and rates."""
    coordinates = {"timestamp": joints[0].timestamp}
    for index, joint in zip(JOINTS, joints):
        coordinates[f"q{index}_rad"] = joint.angle_rad
        coordinates[f"qd{index}_rad_s"] = joint.rate_rad_s
    # The orientation of l22, as in reports.
    coordinates["q13_rad"] = coordinates["q21_rad"] + coordinates["q22_rad"]
    return SimpleNamespace(**coordinates)


@dataclass(frozen=True)
class Message:
    """A decoded message with its times in the log, ns."""

    topic: str
    log_ns: int
    publish_ns: int
    sequence: int
    body: object


@dataclass(frozen=True)
class Log:
    """A log: all messages in file order, channels, metadata, attachments and statistics."""

    channels: dict  # topic: (message encoding, schema)
    messages: tuple
    metadata: dict
    attachments: tuple
    statistics: object

    def on(self, topic):
        """The bodies of the messages of a topic, in order."""
        return [message.body for message in self.messages if message.topic == topic]

    def states(self):
        """The coordinates of a finger at each sample, see `state`."""
        return [state(joints) for joints in zip(*(self.on(topic) for topic in JOINT_TOPICS))]

    def touchdowns(self, contact):
        """Times of the touch-downs of a contact."""
        return [event.timestamp for event in self.on("/event") if event.subject == contact and event.kind == "touch_down"]


@dataclass(frozen=True)
class Run:
    """A run of the program: scene, log, output of `--json`."""

    name: str
    scene: Path
    path: Path
    json: dict

    @functools.cached_property
    def log(self):
        return read(self.path)


def phalanx(*arguments):
    """Runs the program and returns its standard output; raises RuntimeError if the status is not 0."""
    done = subprocess.run([PHALANX, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        raise RuntimeError(f"phalanx {' '.join(map(str, arguments))} ended with {done.returncode}: {done.stderr}")
    return done.stdout


@functools.cache
def run(scene, *options):
    """Runs a scene; the result is cached."""
    name = "-".join([Path(scene).stem, *(option.strip("-") for option in options)]).replace(" ", "")
    path = DIRECTORY / f"{name}.mcap"
    json_output = json.loads(phalanx("run", SCENES / scene, "--log", path, "--json", *options))
    return Run(name, SCENES / scene, path, json_output)


def read(path):
    """Decodes a log; raises an error for a wrong checksum or a message that cannot be decoded."""
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        summary = reader.get_summary()
        messages = tuple(
            Message(channel.topic, message.log_time, message.publish_time, message.sequence, body)
            for _, channel, message, body in reader.iter_decoded_messages(log_time_order=False)
        )
        channels = {
            channel.topic: (channel.message_encoding, summary.schemas[channel.schema_id])
            for channel in summary.channels.values()
        }
        metadata = {record.name: dict(record.metadata) for record in reader.iter_metadata()}
        attachments = tuple(reader.iter_attachments())
    return Log(channels, messages, metadata, attachments, summary.statistics)


def closings():
    """Runs of design 95 in both models, with both presets of the analytic one."""
    return [
        run("experiment-95.toml"),
        run("experiment-95.toml", "--preset", "reference"),
        run("experiment-95.toml", "--model", "engine"),
    ]


def fingers():
    """Runs of fingers: the closings, and a swing without contact."""
    return [*closings(), run("free-swing.toml"), run("free-swing.toml", "--model", "engine")]


def discs():
    """Runs of discs: an impact, and two free discs with friction."""
    return [run("laws/impact.toml"), run("laws/two-free.toml"), run("laws/impact.toml", "--model", "engine")]
