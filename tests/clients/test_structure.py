"""What every reader relies on: one clock, whole descriptors, the scene beside the messages, the same bytes again."""

import hashlib
import math
import unittest

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool

import logs

ALL = [*logs.fingers(), *logs.discs()]


def stamp_ns(stamp):
    """A protobuf timestamp in ns."""
    return stamp.seconds * 1_000_000_000 + stamp.nanos


def stamps(body):
    """Every time that a message carries: the `timestamp` of it or of its parts."""
    kind = body.DESCRIPTOR.full_name
    if kind in ("foxglove.FrameTransforms", "foxglove.SceneUpdate"):
        parts = body.transforms if kind == "foxglove.FrameTransforms" else [*body.entities, *body.deletions]
        return [stamp_ns(part.timestamp) for part in parts]
    if kind.startswith("foxglove."):
        return [stamp_ns(body.timestamp)]
    return [round(body.timestamp * 1e9)]


class Clock(unittest.TestCase):
    def test_never_goes_back(self):
        for run in ALL:
            with self.subTest(run.name):
                times = [message.log_ns for message in run.log.messages]
                self.assertEqual(times[0], 0)
                self.assertEqual(times, sorted(times))

    def test_is_one(self):
        for run in ALL:
            with self.subTest(run.name):
                for message in run.log.messages:
                    self.assertEqual(message.publish_ns, message.log_ns)
                    for stamp in stamps(message.body):
                        # Foxglove's own messages carry the log time; ours the double behind it.
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
                    # A pool of its own: nothing that this process happens to know can fill a gap.
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
        units = "_rad _rad_s _m _m_s _n _n_m _n_s _n_m_s _j".split()
        pure = {"timestamp", "normal_x", "normal_y", "pressed", "touch_down"}
        for run in ALL:
            for message in run.log.messages:
                if message.body.DESCRIPTOR.full_name.startswith("foxglove."):
                    continue
                for field in message.body.DESCRIPTOR.fields:
                    self.assertTrue(field.name in pure or field.name.endswith(tuple(units)), field.name)


class Beside(unittest.TestCase):
    def test_scene_is_attached_byte_for_byte(self):
        for run in ALL:
            with self.subTest(run.name):
                (scene,) = run.log.attachments
                self.assertEqual(scene.name, run.scene.name)
                self.assertEqual(scene.media_type, "application/toml")
                self.assertEqual(scene.data, run.scene.read_bytes())
                self.assertEqual((scene.log_time, scene.create_time), (0, 0))

    def test_metadata_says_what_the_run_says(self):
        for run in ALL:
            with self.subTest(run.name):
                said, noted = run.json, run.log.metadata["phalanx"]
                for key in ("model", "kind", "scene"):
                    self.assertEqual(noted[key], said[key])
                self.assertEqual(float(noted["duration_s"]), said["duration_s"])
                self.assertEqual(noted["scene_file"], run.scene.name)
                settings = {key: value for key, value in (said["integrator"] or {}).items() if value is not None}
                for key, value in settings.items():
                    text = noted[f"integrator_{key}"]
                    self.assertEqual(float(text) if isinstance(value, float) else text, value if isinstance(value, float) else str(value))

    def test_check_is_what_the_run_says_of_itself(self):
        for run in ALL:
            with self.subTest(run.name):
                said, noted = run.json["check"], run.log.metadata["phalanx-check"]
                self.assertEqual(noted["verdict"], said["verdict"])
                unit = "rad" if "error_rad" in said else "m"
                for key, name in (("error", f"error_{unit}"), ("sensitivity", f"sensitivity_{unit}"), ("push", "push"), ("bar", "bar")):
                    # Null where nothing was compared.
                    self.assertEqual(float(noted[key]), math.inf if said[name] is None else said[name], key)

    def test_statistics_count_what_is_there(self):
        for run in ALL:
            with self.subTest(run.name):
                self.assertEqual(run.log.statistics.message_count, len(run.log.messages))
                self.assertEqual(run.log.statistics.attachment_count, 1)
                self.assertEqual(run.log.statistics.metadata_count, len(run.log.metadata))
                self.assertEqual(set(run.log.metadata), {"phalanx", "phalanx-check"})
                self.assertEqual(run.log.statistics.message_end_time, run.log.messages[-1].log_ns)


class Bytes(unittest.TestCase):
    def test_same_run_same_bytes(self):
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

    def test_a_closing_takes_less_than_a_megabyte(self):
        for run in logs.closings():
            with self.subTest(run.name):
                self.assertLess(run.path.stat().st_size, 1_000_000)


if __name__ == "__main__":
    unittest.main()
