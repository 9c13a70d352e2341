"""The files of tools/viewers: the Foxglove layout refers to channels of a log, the Rerun script shows all of them."""

import json
import re
import subprocess
import sys
import unittest

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from rerun.chunk import RrdReader

import logs
from test_rerun import environment, rerun

VIEWERS = logs.PROJECT / "tools" / "viewers"
LAYOUT = VIEWERS / "foxglove_layout.json"

# Functions of Foxglove's message paths that the layout may use.
FUNCTIONS = {"rad2deg", "log1p"}


def strings(value):
    """Yields all keys and strings of a JSON document."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield key
            yield from strings(part)
    elif isinstance(value, list):
        for part in value:
            yield from strings(part)
    elif isinstance(value, str):
        yield value


def panels(tree):
    """Returns the panels in the tree of a layout."""
    return [tree] if isinstance(tree, str) else [*panels(tree["first"]), *panels(tree["second"])]


def fields(schema):
    """Field names of a message, from the descriptor embedded in a log."""
    package, _, name = schema.name.rpartition(".")
    for file in FileDescriptorSet.FromString(schema.data).file:
        if file.package == package:
            for message in file.message_type:
                if message.name == name:
                    return {field.name for field in message.field}
    raise AssertionError(f"{schema.name} is not in its own descriptor")


class Layout(unittest.TestCase):
    def setUp(self):
        self.layout = json.loads(LAYOUT.read_text())
        self.channels = logs.run("experiment-95.toml").log.channels

    def test_shows_every_panel_once(self):
        shown = panels(self.layout["layout"])
        self.assertEqual(sorted(shown), sorted(self.layout["configById"]))
        self.assertEqual({name.split("!")[0] for name in shown}, {"3D", "Plot", "RosOut"})

    def test_colours_match_the_plots(self):
        # As in the plots of the page: blue, orange, green, purple in each panel.
        order = ["#0072b2", "#d55e00", "#009e73", "#aa508c"]
        expected = dict(zip(["q11", "q21", "q22"], order)) | dict(zip(["proximal", "distal"], order))
        expected |= dict(zip(["kinetic", "motor work", "dissipated", "spring"], order))
        found = [series for config in self.layout["configById"].values() for series in config.get("paths", [])]
        self.assertEqual({series["label"] for series in found}, set(expected))
        for series in found:
            self.assertEqual(series["color"], expected[series["label"]], series["value"])
        closing = (VIEWERS.parent / "draw_closing.py").read_text()
        self.assertIn('(("q11", BLUE), ("q21", ORANGE), ("q22", GREEN))', closing)

    def test_message_paths_are_fields_of_the_log(self):
        paths = 0
        for config in self.layout["configById"].values():
            for series in config.get("paths", []):
                with self.subTest(series["value"]):
                    topic, field, *functions = re.fullmatch(r"(/[^.]+)\.(\w+)(?:\.@(\w+))?", series["value"]).groups()
                    self.assertIn(topic, self.channels)
                    self.assertIn(field, fields(self.channels[topic][1]))
                    self.assertLessEqual({name for name in functions if name}, FUNCTIONS)
                    paths += 1
        self.assertGreater(paths, 8)

    def test_every_topic_is_in_the_log(self):
        drawn = self.layout["configById"]["3D!phalanx"]["topics"]
        for topic in drawn:
            self.assertIn(self.channels[topic][1].name, ("foxglove.SceneUpdate", "foxglove.FrameTransforms"))
        events = self.layout["configById"]["RosOut!events"]["topicToRender"]
        self.assertEqual(self.channels[events][1].name, "foxglove.Log")
        for text in strings(self.layout):
            if text.startswith("/"):
                self.assertIn(text.partition(".")[0], self.channels)

    def test_camera_is_fixed_and_shows_the_whole_motion(self):
        panel = self.layout["configById"]["3D!phalanx"]
        camera = panel["cameraState"]
        self.assertEqual((camera["perspective"], camera["phi"], camera["thetaOffset"]), (False, 0, 0))
        self.assertEqual((panel["followMode"], panel["followTf"]), ("follow-none", "world"))
        # The height of an orthographic view equals its distance; all frames must be within it at all times.
        log = logs.run("experiment-95.toml").log
        low = camera["targetOffset"][1] - 0.5 * camera["distance"]
        for body in log.on("/tf"):
            for frame in body.transforms:
                self.assertLess(low, frame.translation.y)
                self.assertLess(frame.translation.y, low + camera["distance"])


class RerunScript(unittest.TestCase):
    def recording(self, run):
        path = run.path.with_name(f"view-{run.path.stem}.rrd")
        command = [sys.executable, VIEWERS / "rerun_view.py", run.path, "--save", path]
        subprocess.run(command, env=environment(), check=True, capture_output=True, text=True, timeout=120)
        output, status = rerun("rrd", "verify", path)
        self.assertEqual(status, 0, output)
        return path

    def rows(self, path):
        """Rows by entity: (time in ns or None, values by component). Asserts that there is a blueprint."""
        reader = RrdReader(path)
        self.assertEqual(len(reader.blueprints()), 1)
        found = {}
        for chunk in reader.stream().to_chunks():
            batch = chunk.to_record_batch()
            components = [name for name in batch.schema.names if ":" in name]
            times = batch.column("time").cast("int64").to_pylist() if "time" in chunk.timeline_names else None
            values = {name: batch.column(name).to_pylist() for name in components}
            for row in range(batch.num_rows):
                entry = {name: column[row] for name, column in values.items()}
                found.setdefault(chunk.entity_path, []).append((times[row] if times else None, entry))
        return found

    def test_has_every_number_on_one_timeline(self):
        for run in [logs.run("experiment-95.toml"), logs.run("laws/two-free.toml", "--model", "engine")]:
            with self.subTest(run.name):
                rows = self.rows(self.recording(run))
                series = 0
                for topic in run.log.channels:
                    messages = [message for message in run.log.messages if message.topic == topic]
                    if not messages or messages[0].body.DESCRIPTOR.full_name.startswith("foxglove."):
                        continue
                    for field in messages[0].body.DESCRIPTOR.fields:
                        if field.name == "timestamp" or field.cpp_type != field.CPPTYPE_DOUBLE:
                            continue
                        expected = [(message.log_ns, getattr(message.body, field.name)) for message in messages]
                        found = rows[f"{topic}/{field.name}"]
                        self.assertEqual([(time, entry["Scalars:scalars"][0]) for time, entry in found], expected)
                        series += 1
                self.assertGreater(series, 20)

    def test_draws_every_body_where_its_frame_is(self):
        run = logs.run("experiment-95.toml")
        rows = self.rows(self.recording(run))
        moving = {}
        for message in run.log.messages:
            if message.topic in ("/tf", "/tf_static"):
                for frame in message.body.transforms:
                    moving.setdefault(frame.child_frame_id, []).append((message.log_ns, frame))
        self.assertEqual(set(moving), {"ground", "palm", "object", "l11", "l12", "l21", "l22"})
        for name, frames in moving.items():
            found = [row for row in rows[f"/world/{name}"] if row[0] is not None]
            self.assertEqual([time for time, _ in found], [time for time, _ in frames])
            for (_, entry), (_, frame) in zip(found, frames):
                ((x, y, _),) = entry["Transform3D:translation"]
                # Rerun draws in single precision.
                self.assertAlmostEqual(x, frame.translation.x, delta=1e-8)
                self.assertAlmostEqual(y, frame.translation.y, delta=1e-8)
            for part in ("outline", "area_0"):
                ((time, entry),) = rows[f"/world/{name}/{part}"]
                self.assertIsNone(time)
                self.assertTrue(any(entry.values()))

    def test_draws_forces_only_in_contact(self):
        run = logs.run("laws/impact.toml")
        rows = self.rows(self.recording(run))
        ((name, _),) = run.json["contacts"].items()
        expected = [(message.log_ns, len(message.body.entities[0].arrows)) for message in run.log.messages if message.topic == "/forces"]
        found = [(time, len(entry["Arrows3D:vectors"])) for time, entry in rows[f"/world/forces/{name}/arrows"]]
        self.assertEqual(found, expected)
        self.assertEqual({count for _, count in found}, {0, 1})

    def test_reports_unreadable_files(self):
        for path in [logs.DIRECTORY / "none.mcap", LAYOUT]:
            command = [sys.executable, VIEWERS / "rerun_view.py", path]
            done = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, r"\Acannot read .*give the log of a finished run\n\Z")


if __name__ == "__main__":
    unittest.main()
