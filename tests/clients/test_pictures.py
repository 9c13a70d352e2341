"""Compares the drawings in the log with its numbers: frames (forward kinematics), contact points, shapes, force arrows."""

import math
import unittest

import finger
import logs

# Rounding errors of lengths of 20 mm and angles of 1 rad through a quaternion.
CLOSE_M = 1e-12


def plane(transform):
    """Origin and angle of a frame; asserts that it is planar."""
    (x, y, z), turn = (getattr(transform.translation, axis) for axis in "xyz"), transform.rotation
    assert z == 0.0 and turn.x == 0.0 and turn.y == 0.0, transform
    assert abs(math.hypot(turn.z, turn.w) - 1.0) < 1e-12, transform
    return (x, y), 2.0 * math.atan2(turn.z, turn.w)


def with_numbers(log, topic, numbers):
    """Yields the messages of a topic with the latest messages of other topics; drawings of a sample follow its numbers."""
    latest = {}
    for message in log.messages:
        if message.topic == topic:
            yield message.body, [latest[name] for name in numbers]
        elif message.topic in numbers:
            latest[message.topic] = message.body


class Frames(unittest.TestCase):
    def assertAt(self, point, x, y, tolerance=CLOSE_M):
        self.assertLessEqual(math.hypot(point[0] - x, point[1] - y), tolerance)

    def test_link_frames_match_joint_angles(self):
        for run in logs.fingers():
            with self.subTest(run.name):
                lengths = finger.finger(run.scene)
                seen = 0
                for body, joints in with_numbers(run.log, "/tf", logs.JOINT_TOPICS):
                    expected = finger.frames(lengths, logs.state(joints))
                    self.assertEqual([frame.child_frame_id for frame in body.transforms], list(expected))
                    for frame in body.transforms:
                        origin, angle = plane(frame)
                        position, turn = expected[frame.child_frame_id]
                        self.assertAt(origin, *position)
                        self.assertAlmostEqual(math.remainder(angle - turn, math.tau), 0.0, delta=1e-12)
                    seen += 1
                self.assertGreater(seen, 20)

    def test_the_loop_is_closed(self):
        for run in logs.fingers():
            with self.subTest(run.name):
                lengths = finger.finger(run.scene)
                # Joints of the engine open by at most the reported gap.
                open_m = run.json["loop_gap_m"] or 0.0
                for body in run.log.on("/tf"):
                    at = {frame.child_frame_id: plane(frame) for frame in body.transforms}
                    coupler = finger.along(at["l12"][0], lengths.l12, at["l12"][1])
                    self.assertAt(finger.along(at["l22"][0], lengths.l22, at["l22"][1]), *coupler, 1e-9 + open_m)

    def test_contact_points_and_gaps(self):
        for run in logs.closings():
            with self.subTest(run.name):
                lengths = finger.finger(run.scene)
                for body, contacts in with_numbers(run.log, "/tf", ["/contact/proximal", "/contact/distal"]):
                    at = {frame.child_frame_id: plane(frame) for frame in body.transforms}
                    joint, turn = at["l22"]
                    ends = [at["l21"][0], joint, finger.along(joint, lengths.t22, turn + lengths.phi22)]
                    for contact, start, end in zip(contacts, ends, ends[1:]):
                        gap, point, normal = finger.contact(lengths, start, end)
                        tolerance = CLOSE_M
                        if run.json["model"] == "engine":
                            # Between steps of up to 60 us, each number is interpolated independently.
                            tolerance = 2e-8 if contact.normal_n > 0.0 else 1e-6
                        self.assertAlmostEqual(contact.gap_m, gap, delta=tolerance)
                        self.assertAt(point, contact.point_x_m, contact.point_y_m, tolerance)
                        self.assertAt(normal, contact.normal_x, contact.normal_y, tolerance / lengths.half_width)

    def test_disc_frames_match_positions(self):
        for run in logs.discs():
            with self.subTest(run.name):
                fixed = {frame.child_frame_id for body in run.log.on("/tf_static") for frame in body.transforms}
                names = [name for name in run.json["bodies"] if name not in fixed]
                for body, states in with_numbers(run.log, "/tf", [f"/body/{name}" for name in names]):
                    at = {frame.child_frame_id: plane(frame) for frame in body.transforms}
                    for name, state in zip(names, states):
                        self.assertAt(at[name][0], state.x_m, state.y_m)
                        self.assertAlmostEqual(math.remainder(at[name][1] - state.angle_rad, math.tau), 0.0, delta=1e-9)


class Order(unittest.TestCase):
    def test_frames_are_connected_to_world_before_use(self):
        for run in logs.fingers() + logs.discs():
            with self.subTest(run.name):
                known = {"world"}
                entities = 0
                for message in run.log.messages:
                    kind = message.body.DESCRIPTOR.full_name
                    if kind == "foxglove.FrameTransforms":
                        for frame in message.body.transforms:
                            self.assertIn(frame.parent_frame_id, known)
                            known.add(frame.child_frame_id)
                    elif kind == "foxglove.SceneUpdate":
                        for entity in message.body.entities:
                            self.assertIn(entity.frame_id, known, f"{message.topic} at {message.log_ns} ns")
                            entities += 1
                self.assertGreater(entities, 4)

    def test_transforms_come_first_in_each_sample(self):
        # Samples less than a nanosecond apart share a stamp, so samples are separated by topic: each ends with its drawings.
        for run in logs.fingers() + logs.discs():
            with self.subTest(run.name):
                before = None
                for message in run.log.messages:
                    if message.topic == "/tf":
                        self.assertEqual(before, "/energy")
                    elif message.topic == "/forces":
                        self.assertIn(before, ("/tf", "/scene", "/energy"))
                    before = message.topic

    def test_geometry_is_logged_once(self):
        for run in logs.fingers() + logs.discs():
            with self.subTest(run.name):
                self.assertEqual(len(run.log.on("/scene")), 1)
                self.assertEqual(len(run.log.on("/tf_static")), 1)
                ids = [entity.id for entity in run.log.on("/scene")[0].entities]
                self.assertEqual(len(ids), len(set(ids)))
                self.assertTrue(all(entity.frame_locked for entity in run.log.on("/scene")[0].entities))


class Shapes(unittest.TestCase):
    def outlines(self, run):
        """Corners of the closed lines of every body, in its own frame."""
        (scene,) = run.log.on("/scene")
        return {
            entity.id: [[(point.x, point.y) for point in line.points] for line in entity.lines]
            for entity in scene.entities
        }

    def test_contact_surfaces_have_the_size_of_the_scene(self):
        run = logs.run("experiment-95.toml")
        lengths, outlines = finger.finger(run.scene), self.outlines(run)
        self.assertEqual(set(outlines), {"ground", "palm", "object", "l11", "l12", "l21", "l22"})
        (disc,) = outlines["object"]
        for x, y in disc:
            self.assertAlmostEqual(math.hypot(x, y), lengths.radius, delta=CLOSE_M)
        # The last outline of a phalanx is its surface, at half a width from its centre line.
        for name, length, angle in [("l21", lengths.l21, 0.0), ("l22", lengths.t22, lengths.phi22)]:
            end = finger.along((0.0, 0.0), length, angle)
            for x, y in outlines[name][-1]:
                near = finger.nearest((x, y), (0.0, 0.0), end)
                self.assertAlmostEqual(math.hypot(x - near[0], y - near[1]), lengths.half_width, delta=CLOSE_M)

    def test_discs_have_their_radius(self):
        run = logs.run("laws/two-free.toml")
        # The ground has no outline.
        discs = [(name, lines[0]) for name, lines in self.outlines(run).items() if lines]
        self.assertEqual(len(discs), 2)
        for name, outline in discs:
            sizes = {round(math.hypot(x, y), 12) for x, y in outline}
            self.assertEqual(len(sizes), 1, name)
            self.assertIn(f'"{sizes.pop() * 1e3:g} mm"', run.scene.read_text())

    def test_triangles_cover_the_outlines(self):
        for run in [logs.run("experiment-95.toml"), logs.run("laws/two-free.toml")]:
            for entity in run.log.on("/scene")[0].entities:
                for line, triangles in zip(entity.lines, entity.triangles, strict=True):
                    with self.subTest(run.name, entity=entity.id):
                        corners = [(point.x, point.y) for point in line.points]
                        turned = zip(corners, corners[1:] + corners[:1])
                        area = 0.5 * sum(a[0] * b[1] - a[1] * b[0] for a, b in turned)
                        points = [(triangles.points[k].x, triangles.points[k].y) for k in triangles.indices]
                        filled = 0.0
                        for a, b, c in zip(points[::3], points[1::3], points[2::3]):
                            part = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
                            self.assertGreaterEqual(part, -1e-18)
                            filled += part
                        self.assertAlmostEqual(filled, area, delta=1e-9 * area)


class Forces(unittest.TestCase):
    def test_arrows_start_at_contact_points_along_forces(self):
        for run in logs.closings() + logs.discs():
            with self.subTest(run.name):
                names = [name for name in run.json["contacts"] if name != "limit"]
                scales, arrows = [], 0
                for body, contacts in with_numbers(run.log, "/forces", [f"/contact/{name}" for name in names]):
                    self.assertEqual([entity.id for entity in body.entities], names)
                    for entity, contact in zip(body.entities, contacts):
                        if contact.normal_n <= 0.0:
                            self.assertEqual((len(entity.arrows), len(entity.spheres)), (0, 0))
                            continue
                        forces = [(contact.normal_n, (contact.normal_x, contact.normal_y))]
                        if contact.tangential_n != 0.0:
                            forces.append((contact.tangential_n, (-contact.normal_y, contact.normal_x)))
                        self.assertEqual(len(entity.spheres), 1)
                        for arrow, (force, direction) in zip(entity.arrows, forces, strict=True):
                            at, turn = arrow.pose.position, arrow.pose.orientation
                            self.assertEqual((at.x, at.y), (contact.point_x_m, contact.point_y_m))
                            angle = 2.0 * math.atan2(turn.z, turn.w)
                            pointing = math.copysign(1.0, force)
                            along = math.cos(angle) * direction[0] + math.sin(angle) * direction[1]
                            self.assertAlmostEqual(along, pointing, delta=1e-9)
                            scales.append((arrow.shaft_length + arrow.head_length) / abs(force))
                            arrows += 1
                self.assertGreater(arrows, 10)
                # One scale for all, except for impact forces, whose arrows are limited in length.
                usual = max(scales)
                self.assertTrue(any(abs(scale - usual) < 1e-6 * usual for scale in scales))
                self.assertTrue(all(scale > 0.0 for scale in scales))

    def test_last_arrows_are_the_final_forces(self):
        for run in logs.closings():
            with self.subTest(run.name):
                for entity in run.log.on("/forces")[-1].entities:
                    self.assertGreater(run.json["contacts"][entity.id]["final_normal_n"], 0.0)
                    self.assertGreaterEqual(len(entity.arrows), 1)


if __name__ == "__main__":
    unittest.main()
