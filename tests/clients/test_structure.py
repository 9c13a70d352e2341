"""Structure of the logs: one clock, complete descriptors, attached scene and metadata, reproducible bytes."""

import hashlib
import math
import unittest

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool

import logs

ALL = [*logs.fingers(), *logs.discs()]


def stamp_ns(stamp):
    """Converts a protobuf timestamp to ns."""
    return stamp.seconds * 1_000_000_000 + stamp.nanos


def stamps(body):
    """All time stamps of a message: its `timestamp`, or those of its parts."""
    kind = body.DESCRIPTOR.full_name
    if kind in ("foxglove.FrameTransforms", "foxglove.SceneUpdate"):
        parts = body.transforms if kind == "foxglove.FrameTransforms" else [*body.entities, *body.deletions]
        return [stamp_ns(part.timestamp) for part in parts]
    if kind.startswith("foxglove."):
        return [stamp_ns(body.timestamp)]
    return [round(body.timestamp * 1e9)]


class Clock(unittest.TestCase):
    def test_is_monotonic(self):
        for run in ALL:
            with self.subTest(run.name):
                times = [message.log_ns for message in run.log.messages]
                self.assertEqual(times[0], 0)
                self.assertEqual(times, sorted(times))

    def test_log_and_message_times_agree(self):
        for run in ALL:
            with self.subTest(run.name):
                for message in run.log.messages:
                    self.assertEqual(message.publish_ns, message.log_ns)
                    for stamp in stamps(message.body):
                        # Messages of Foxglove contain the log time, those of phalanx the unrounded time.
                        exact = message.body.DESCRIPTOR.full_name.startswith("foxglove.")
                        self.assertLessEqual(abs(stamp - message.log_ns), 0 if exact else 1, message.topic)

    def test_ends_with_the_run(self):
        for run in ALL:
            with self.subTest(run.name):
                last = run.log.messages[-1]
                self.assertEqual((last.topic, last.body.message), ("/events", "completed"))
                self.assertEqual(last.log_ns, round(run.json["end_s"] * 1e9))

    def test_sequence_counts_the_messages_of_a_channel(self):
        for run in ALL:
            with self.subTest(run.name):
                seen = {}
                for message in run.log.messages:
                    self.assertEqual(message.sequence, seen.get(message.topic, 0))
                    seen[message.topic] = message.sequence + 1


class Descriptors(unittest.TestCase):
    def test_are_embedded_and_complete(self):
        for run in ALL:
            for topic, (encoding, schema) in run.log.channels.items():
                with self.subTest(run.name, topic=topic):
                    self.assertEqual((encoding, schema.encoding), ("protobuf", "protobuf"))
                    self.assertTrue(schema.name.startswith(("phalanx.", "foxglove.")), schema.name)
                    files = {file.name: file for file in FileDescriptorSet.FromString(schema.data).file}
                    # A separate pool, so that types known to this process cannot fill a gap.
                    pool = DescriptorPool()

                    def add(name):
                        file = files.pop(name, None)
                        if file is not None:
                            for dependency in file.dependency:
                                add(dependency)
                            pool.Add(file)

                    for name in list(files):
                        add(name)
                    found = pool.FindMessageTypeByName(schema.name)
                    self.assertGreater(len(found.fields), 0)

    def test_every_field_of_a_plotted_message_has_a_unit_in_its_name(self):
        units = "_rad _rad_s _m _m_s _n _n_m _n_s _n_m_s _j _w".split()
        pure = {"timestamp", "normal_x", "normal_y"}
        for run in ALL:
            for message in run.log.messages:
                if message.body.DESCRIPTOR.full_name.startswith("foxglove."):
                    continue
                numbers = [field for field in message.body.DESCRIPTOR.fields if field.type == field.TYPE_DOUBLE]
                self.assertGreater(len(numbers), 1)
                for field in numbers:
                    self.assertTrue(field.name in pure or field.name.endswith(tuple(units)), field.name)


class SceneAndMetadata(unittest.TestCase):
    def test_scene_is_attached_byte_for_byte(self):
        for run in ALL:
            with self.subTest(run.name):
                (scene,) = run.log.attachments
                self.assertEqual(scene.name, run.scene.name)
                self.assertEqual(scene.media_type, "application/toml")
                self.assertEqual(scene.data, run.scene.read_bytes())
                self.assertEqual((scene.log_time, scene.create_time), (0, 0))

    def test_metadata_equals_the_output_of_the_run(self):
        for run in ALL:
            with self.subTest(run.name):
                reported, metadata = run.json, run.log.metadata["phalanx"]
                for key in ("model", "kind", "scene"):
                    self.assertEqual(metadata[key], reported[key])
                self.assertEqual(float(metadata["duration_s"]), reported["duration_s"])
                self.assertEqual(metadata["scene_file"], run.scene.name)
                settings = {key: value for key, value in (reported["integrator"] or {}).items() if value is not None}
                for key, value in settings.items():
                    text = metadata[f"integrator_{key}"]
                    self.assertEqual(float(text) if isinstance(value, float) else text, value if isinstance(value, float) else str(value))

    def test_check_equals_the_output_of_the_run(self):
        for run in ALL:
            with self.subTest(run.name):
                reported, metadata = run.json["check"], run.log.metadata["phalanx-check"]
                self.assertEqual(metadata["verdict"], reported["verdict"])
                unit = "rad" if "error_rad" in reported else "m"
                for key, name in (("error", f"error_{unit}"), ("sensitivity", f"sensitivity_{unit}"), ("push", "push"), ("bar", "bar")):
                    # Null if nothing was compared.
                    self.assertEqual(float(metadata[key]), math.inf if reported[name] is None else reported[name], key)

    def test_statistics_count_the_records(self):
        for run in ALL:
            with self.subTest(run.name):
                self.assertEqual(run.log.statistics.message_count, len(run.log.messages))
                self.assertEqual(run.log.statistics.attachment_count, 1)
                self.assertEqual(run.log.statistics.metadata_count, len(run.log.metadata))
                self.assertEqual(set(run.log.metadata), {"phalanx", "phalanx-check", "phalanx-subjects"})
                self.assertEqual(run.log.statistics.message_end_time, run.log.messages[-1].log_ns)


class Bytes(unittest.TestCase):
    def test_equal_runs_have_equal_bytes(self):
        for scene, *options in [
            ("experiment-95.toml",),
            ("experiment-95.toml", "--model", "engine"),
            ("laws/impact.toml",),
        ]:
            with self.subTest(scene, options=options):
                first = logs.run(scene, *options)
                again = logs.DIRECTORY / f"again-{first.name}.mcap"
                logs.phalanx("run", logs.SCENES / scene, "--log", again, *options)
                digests = [hashlib.sha256(path.read_bytes()).hexdigest() for path in (first.path, again)]
                self.assertEqual(*digests)

    def test_the_size_of_a_closing_is_bounded(self):
        for run in logs.closings():
            with self.subTest(run.name):
                self.assertLess(run.path.stat().st_size, 1_070_000)


if __name__ == "__main__":
    unittest.main()
