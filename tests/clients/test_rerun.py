"""Rerun accepts the logs, and converts them without loss of numbers."""

import functools
import os
import subprocess
import sys
import unittest
from pathlib import Path

import numpy
from rerun.chunk import RrdReader

import logs

RERUN = Path(sys.executable).with_name("rerun")


@functools.cache
def environment():
    """Environment with usage statistics disabled."""
    home = logs.DIRECTORY / "home"
    directories = {"HOME": home, "XDG_CONFIG_HOME": home / "config", "XDG_DATA_HOME": home / "data"}
    changed = {**os.environ, **{name: str(directory) for name, directory in directories.items()}}
    for directory in directories.values():
        directory.mkdir(exist_ok=True)
    subprocess.run([RERUN, "analytics", "disable"], env=changed, check=True, capture_output=True, timeout=60)
    return changed


def rerun(*arguments):
    """Runs the program of Rerun; returns its output (stdout and stderr) and status."""
    command = [RERUN, *map(str, arguments)]
    done = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=120)
    return done.stdout + done.stderr, done.returncode


@functools.cache
def converted(log):
    """Converts a log to a Rerun recording; returns its path."""
    path = log.with_suffix(".rrd")
    output, status = rerun("mcap", "convert", log, "-o", path)
    if status != 0:
        raise RuntimeError(output)
    return path


def rows(recording):
    """All rows with a time, in order: entity to a list of (time in ns, values by component)."""
    found = {}
    for chunk in RrdReader(recording).stream().to_chunks():
        if not chunk.timeline_names:
            continue
        batch = chunk.to_record_batch()
        timeline = next(name for name in chunk.timeline_names if name in ("message_log_time", "time"))
        times = batch.column(timeline).cast("int64").to_pylist()
        components = [name for name in batch.schema.names if ":" in name]
        values = [batch.column(name).to_pylist() for name in components]
        for row, time_ns in enumerate(times):
            entry = {name: column[row] for name, column in zip(components, values)}
            found.setdefault(chunk.entity_path, []).append((time_ns, entry))
    return found


RUNS = [
    logs.run("experiment-95.toml"),
    logs.run("experiment-95.toml", "--preset", "reference"),
    logs.run("experiment-95.toml", "--model", "engine"),
    logs.run("free-swing.toml"),
    logs.run("laws/impact.toml"),
]


class Rerun(unittest.TestCase):
    def test_check_accepts_the_logs(self):
        for run in RUNS:
            with self.subTest(run.name):
                output, status = rerun("mcap", "check", "--full", run.path)
                self.assertEqual(status, 0, output)
                for topic in run.log.channels:
                    (line,) = [line for line in output.splitlines() if topic in line.split()]
                    self.assertEqual(line.split()[0], "ok", line)

    def test_check_detects_a_truncated_log(self):
        # The same command on half a log must fail, so the check is meaningful.
        broken = logs.DIRECTORY / "half.mcap"
        whole = RUNS[0].path.read_bytes()
        broken.write_bytes(whole[: len(whole) // 2])
        self.assertNotEqual(rerun("mcap", "check", broken)[1], 0)

    def test_a_converted_log_has_every_number(self):
        for run in RUNS:
            with self.subTest(run.name):
                output, status = rerun("rrd", "verify", converted(run.path))
                self.assertEqual(status, 0, output)
                found = rows(converted(run.path))
                for topic in run.log.channels:
                    messages = [message for message in run.log.messages if message.topic == topic]
                    if not messages or messages[0].body.DESCRIPTOR.full_name.startswith("foxglove."):
                        continue
                    self.assertEqual(len(found[topic]), len(messages), topic)
                    fields = [field.name for field in messages[0].body.DESCRIPTOR.fields]
                    theirs, ours = [], []
                    for (time_ns, entry), message in zip(found[topic], messages):
                        (((value,),),) = [tuple(entry.values())]
                        theirs.append([time_ns, *(value[field] for field in fields)])
                        ours.append([message.log_ns, *(getattr(message.body, field) for field in fields)])
                    numpy.testing.assert_array_equal(numpy.array(theirs), numpy.array(ours), topic)

    def test_events_are_text(self):
        for run in RUNS:
            with self.subTest(run.name):
                texts = [entry["TextLog:text"][0] for _, entry in rows(converted(run.path))["/events"]]
                expected = [message.message for message in run.log.on("/events")]
                self.assertEqual(len(texts), len(expected))
                for theirs, ours in zip(texts, expected):
                    self.assertIn(ours, theirs)


if __name__ == "__main__":
    unittest.main()
