"""MuJoCo models become scenes with the same motion, and everything that is lost is named."""

import itertools
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock
from xml.etree import ElementTree

import numpy as np
import phalanx
from common import SCENES, command

try:
    import mujoco
except ImportError:
    mujoco = None

if mujoco is not None:
    from phalanx.convert.rigid import free_motion, rigid

# Largest difference of a coordinate from that of the hand-written scene, rad or m.
HAND_WRITTEN = 1e-6
# Tolerance of the motion beside MuJoCo over 50 ms, rad or m; it is larger where the force of a servo reaches its limit within a step.
RIGID = 1e-8
CLIPPED = {"gear": 2e-8, "coef": 4e-8}
# Models of MuJoCo, each with a scene of the same mechanism, written by hand from the same numbers. A wrong rule shows in one of them.
MODELS = sorted((Path(__file__).parent / "mujoco_models").glob("*.xml"))
# A link of 20 g. In the plane x-z, a positive turn about the axis 0 -1 0 is counter-clockwise.
LINK = '<inertial pos="0.03 0 0.002" mass="0.02" diaginertia="8e-6 8e-6 8e-6"/>'


def mjcf(world: str, rest: str = "") -> str:
    """A model without gravity, in radians."""
    return f'<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody>{world}</worldbody>{rest}</mujoco>'


def convert(text: str, **options: object) -> phalanx.Conversion:
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "model.xml"
        path.write_text(text)
        return phalanx.from_mjcf(path, **options)


def notes(conversion: phalanx.Conversion, kind: str) -> str:
    return "\n".join(str(note) for note in conversion.report.of(kind))


def difference(first: phalanx.Result, a: str, second: phalanx.Result, b: str) -> float:
    """Largest difference of two columns at the times that both runs have."""
    _, i, j = np.intersect1d(first.time, second.time, return_indices=True)
    assert len(i) > 200
    return float(np.abs(first[a][i] - second[b][j]).max())


def column(conversion: phalanx.Conversion, name: str) -> str:
    joint = next(joint for joint in conversion.mechanism.joints if joint.name == name)
    return f"{name}_position_m" if joint.is_slide else f"{name}_rad"


def rigid_with_equalities_of(text: str) -> object:
    """The rigid copy of another model, for `free_motion`."""
    conversion = convert(text)
    return rigid(conversion.source, conversion.plane)


def numbers(model: object) -> dict[str, list[float]]:
    """Numbers of a model that do not depend on the frames of its bodies, by element."""
    found = {"key": [*model.key_qpos[0], *model.key_qvel[0]], "gravity": [*model.opt.gravity]}
    for k in range(1, model.nbody):
        found[f"body {model.body(k).name}"] = [model.body_mass[k], model.body_inertia[k].max()]
    for k in range(model.njnt):
        dof, stiffness = model.jnt_dofadr[k], np.ravel(model.jnt_stiffness[k])[0]
        found[f"joint {model.joint(k).name}"] = [
            model.dof_damping[dof], model.dof_armature[dof], model.dof_frictionloss[dof], model.qpos0[model.jnt_qposadr[k]],
            stiffness, model.qpos_spring[model.jnt_qposadr[k]] if stiffness else 0.0, *(model.jnt_range[k] if model.jnt_limited[k] else ()),
        ]  # fmt: skip
    for k in range(model.ntendon):
        first, count = model.tendon_adr[k], model.tendon_num[k]
        found[f"tendon {model.tendon(k).name}"] = [
            *model.wrap_prm[first : first + count],
            *model.tendon_lengthspring[k],
            *np.ravel(model.tendon_stiffness[k]),
        ]
    for k in range(model.nu):
        # The constant part of a force, and its changes with length and rate.
        force = model.actuator_gainprm[k, 0] * model.key_ctrl[0, k] + model.actuator_biasprm[k, 0]
        limit = model.actuator_forcerange[k] if model.actuator_forcelimited[k] else ()
        found[f"actuator {model.actuator(k).name}"] = [force, *model.actuator_biasprm[k, 1:3], *limit]
    return found


@unittest.skipIf(mujoco is None, "needs mujoco")
class Motions(unittest.TestCase):
    def test_equal_those_of_hand_written_scenes(self):
        self.assertGreaterEqual(len(MODELS), 17)
        for path in MODELS:
            with self.subTest(model=path.stem):
                conversion = phalanx.from_mjcf(path, duration=0.05)
                own = phalanx.run(conversion.scene, preset="reference")
                hand_written = phalanx.run(path.with_suffix(".toml"), preset="reference")
                moved = 0.0
                for joint in (joint.name for joint in conversion.mechanism.joints if joint.index >= 0):
                    name = column(conversion, joint)
                    self.assertLess(difference(own, name, hand_written, name), HAND_WRITTEN, joint)
                    moved = max(moved, float(np.ptp(hand_written[name])))
                self.assertGreater(moved, 1e-3)

    def test_equal_those_of_mujoco_with_rigid_constraints(self):
        for path in MODELS:
            with self.subTest(model=path.stem):
                conversion = phalanx.from_mjcf(path)
                found = free_motion(conversion.source, conversion.plane, conversion.mechanism, 0.05)
                self.assertEqual(len(found), conversion.source.model.njnt)
                self.assertLess(max(found.values()), CLIPPED.get(path.stem, RIGID))

    def test_the_orientation_of_a_model_in_space_has_no_effect(self):
        for path in MODELS:
            with self.subTest(model=path.stem):
                drawn = phalanx.from_mjcf(path)
                base = drawn.mechanism
                tree = ElementTree.parse(path)
                world = tree.find("worldbody")
                turned = ElementTree.Element("body", name="turned", pos="0.3 -0.2 0.5", quat="0.8 -0.4 0.2 0.4")
                turned.extend(list(world))
                world[:] = [turned]
                # The same gravity, in the frame of the turned body.
                rotation = np.zeros(9)
                mujoco.mju_quat2Mat(rotation, np.array([0.8, -0.4, 0.2, 0.4]))
                option = tree.find("option")
                gravity = np.array([float(part) for part in option.get("gravity").split()])
                option.set("gravity", " ".join(map(str, rotation.reshape(3, 3) @ gravity)))
                conversion = convert(ElementTree.tostring(tree.getroot(), encoding="unicode"))
                found = conversion.mechanism
                # Rounding errors do not hide that joints are at the origins of their bodies.
                self.assertEqual(conversion.toml.count("\nat = "), drawn.toml.count("\nat = "))
                np.testing.assert_allclose(found.gravity, base.gravity, atol=1e-9)
                for one, other in zip(found.bodies, base.bodies, strict=True):
                    np.testing.assert_allclose([one.mass, one.inertia, *one.com], [other.mass, other.inertia, *other.com], rtol=1e-9, atol=1e-10)
                for one, other in zip(found.joints, base.joints, strict=True):
                    self.assertEqual((one.name, one.bodies, one.start), (other.name, other.bodies, other.start))
                    self.assertAlmostEqual(np.cos(one.axis - other.axis), 1.0, delta=1e-12)
                    # The points of the ground have another origin in models without a base.
                    shift = np.array([np.subtract(a, b) for a, b in zip(one.points, other.points, strict=True)])
                    moves = [k for k in (0, 1) if one.bodies[k] != "ground"]
                    np.testing.assert_allclose(shift[moves], 0.0, atol=1e-9)

    def test_welds_and_floating_bases(self):
        finger = (
            '<body name="{0}" pos="{1} 0 {2}"><joint name="{0}" axis="0 -1 0"/>'
            + LINK
            + '<body name="{0}_tip" pos="0.06 0 0"><joint name="{0}_tip" axis="0 -1 0"/>'
            + LINK
            + "</body></body>"
        )
        fingers = finger.format("a", 0, 0) + finger.format("b", 0.1, 0.02)
        drive = '<actuator><motor name="m" joint="a"/></actuator>'
        # The tips are one body: a four-bar of a, b and the tips. The same with two pins in place of the weld.
        weld = convert(mjcf(fingers, f'<equality><weld name="glue" body1="a_tip" body2="b_tip"/></equality>{drive}'), ctrl={"m": 0.02})
        pins = '<connect body1="a_tip" body2="b_tip" anchor="0 0 0"/><connect body1="a_tip" body2="b_tip" anchor="0.03 0 0"/>'
        pinned = mjcf(fingers, f"<equality>{pins}</equality>{drive}")
        self.assertEqual({body.name: body.members for body in weld.mechanism.bodies}["a_tip"], ["a_tip", "b_tip"])
        self.assertEqual(len(weld.mechanism.joints), 4)
        found = free_motion(weld.source, weld.plane, weld.mechanism, 0.03, rigid_with_equalities_of(pinned))
        self.assertLess(max(found.values()), 1e-7)
        box = '<body name="box" pos="0.16 0 0"><freejoint/><geom name="box" size="0.01"/></body>'
        for world in (box + fingers, fingers + box):
            held = convert(mjcf(world, '<equality><weld body1="box" body2="b_tip"/></equality>'))
            self.assertEqual([body.name for body in held.mechanism.bodies], ["a", "a_tip", "b", "b_tip"])
            self.assertEqual(sorted(held.mechanism.bodies[3].members), ["b_tip", "box"])
        merged = convert(pinned)
        self.assertEqual([body.members for body in merged.mechanism.bodies if len(body.members) > 1], [["a_tip", "b_tip"]])
        self.assertIn("the second pin", notes(merged, "changed"))
        floating = mjcf(f'<body name="palm" pos="0.3 0 0.2"><freejoint/><geom size="0.01"/>{fingers}</body>', drive)
        conversion = convert(floating)
        self.assertEqual((conversion.source.root, len(conversion.mechanism.joints)), ("palm", 4))
        self.assertIn("body palm: the base of the hand floats", notes(conversion, "changed"))
        two = "".join(
            f'<body name="{name}"><freejoint/><geom size="0.01"/>{fingers.replace("name=" + chr(34), "name=" + chr(34) + name)}</body>'
            for name in "xy"
        )
        with self.assertRaisesRegex(phalanx.ConversionError, "2 hands that float"):
            convert(mjcf(two))

    def test_free_bodies_keep_their_pose_and_rates(self):
        # Two slides and a hinge, and a free joint, both thrown, with a key frame that turns them by 1 and 0.5 rad about the normal -y.
        free = '<body name="ball" pos="0.5 0 0.2"><freejoint/>' + LINK + '<geom name="ball" type="box" size="0.02 0.01 0.005"/></body>'
        planar = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint axis="0 -1 0"/>'
        planar = f'<body name="plate" pos="-0.5 0 0.1">{planar}{LINK}<geom name="plate" type="capsule" fromto="0 0 0 0.05 0 0" size="0.01"/></body>'
        hand = f'<body name="link"><joint name="pin" axis="0 -1 0"/>{LINK}</body>'
        turned = f"{np.cos(0.25)} 0 {-np.sin(0.25)} 0"
        key = f'<keyframe><key qpos="0 0.6 0.003 0.3 {turned} 0.1 -0.2 1" qvel="1 0.3 0 -0.2 0 -2 0 0.5 0.7 3"/></keyframe>'
        text = mjcf(hand + free + planar, key).replace('gravity="0 0 0"', 'gravity="1 0 -9.81" timestep="1e-5" integrator="RK4"')
        conversion = convert(text, duration=0.05)
        result = phalanx.run(conversion.scene, preset="reference")
        model = mujoco.MjModel.from_xml_string(text)
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        mujoco.mj_step(model, data, nstep=5000)
        for body, turn in (("ball", -2 * np.arcsin(data.xquat[2][2])), ("plate", data.qpos[-1])):
            x, _, z = data.body(body).xpos
            found = [result[f"{body}_{name}"][-1] for name in ("x_m", "y_m", "angle_rad")]
            np.testing.assert_allclose(found, [x, z, turn], atol=1e-9)

    def test_friction_holds(self):
        drive = '<actuator><motor name="m" joint="j"/></actuator>'
        for torque, moves in ((0.09, False), (0.11, True)):
            text = mjcf(f'<body name="a"><joint name="j" axis="0 -1 0" frictionloss="0.1"/>{LINK}</body>', drive)
            result = phalanx.run(convert(text, ctrl={"m": torque}, duration=0.2).scene)
            if moves:
                # The excess of 0.01 N·m accelerates 2.608e-5 kg m^2.
                self.assertAlmostEqual(result["j_rad"][-1], 0.5 * 0.01 / 2.608e-5 * 0.2**2, delta=0.02)
            else:
                self.assertLess(np.abs(result["j_rad"]).max(), 2e-5)
                self.assertLess(abs(result["j_rate_rad_s"][-1]), 1e-9)

    def test_export_and_back_gives_the_same_numbers(self):
        scenes = sorted([*(SCENES / "mechanisms").glob("*.toml"), *(SCENES / "real").glob("*.toml")])
        self.assertGreater(len(scenes), 14)
        # MuJoCo has no servo of a distance: the model of this drive has a force that nothing commands.
        for path in (path for path in scenes if path.stem != "bought-drive"):
            with self.subTest(scene=path.stem):
                first = phalanx.Scene.load(path).to_mjcf()
                second = convert(first).scene.to_mjcf()
                before, after = (numbers(mujoco.MjModel.from_xml_string(text)) for text in (first, second))
                # A constant torque of a spring comes back as an actuator.
                before = {name: values for name, values in before.items() if not (name.startswith("tendon") and name.endswith("spring"))}
                self.assertEqual(before.keys() - after.keys(), set())
                for name, values in before.items():
                    np.testing.assert_allclose(after[name], values, rtol=1e-9, atol=1e-12, err_msg=name)

    def test_export_and_back_gives_the_same_motion(self):
        for name in ("four-bar", "slider-crank", "andrews"):
            with self.subTest(scene=name):
                scene = phalanx.Scene.load(SCENES / "mechanisms" / f"{name}.toml")
                conversion = convert(scene.to_mjcf(), duration=scene.duration_s)
                tight = {"duration": min(scene.duration_s, 0.05), "rtol": 1e-12}
                first, second = phalanx.run(scene, **tight), phalanx.run(conversion.scene, **tight)
                model = conversion.source.model
                for joint in (model.joint(k).name for k in range(model.njnt)):
                    # Andrews' mechanism turns ten times in 30 ms, and multiplies rounding errors.
                    bound = 1e-6 if name == "andrews" else 1e-9
                    self.assertLess(difference(first, column(conversion, joint), second, column(conversion, joint)), bound)


@unittest.skipIf(mujoco is None, "needs mujoco")
class Refusals(unittest.TestCase):
    def assert_refused(self, text: str, *parts: str, **options: object) -> None:
        with self.assertRaises(phalanx.ConversionError) as raised:
            convert(text, **options)
        for part in parts:
            self.assertIn(part, str(raised.exception))

    def test_name_the_axis_that_contradicts(self):
        hand = f'<body name="wrist"><joint name="roll" axis="0 0 1"/>{LINK}<body name="palm" pos="0 0 0.1"><geom size="0.01"/>'
        hand += "".join(
            f'<body name="{name}" pos="{x} 0 0"><joint name="{name}" axis="0 -1 0"/>{LINK}</body>' for name, x in (("left", -0.02), ("right", 0.02))
        )
        hand = mjcf(hand + "</body></body>")
        self.assert_refused(hand, "joint roll", "(0, 0, 1)", "90 deg", 'root="wrist"')
        conversion = convert(hand, root="palm")
        self.assertEqual([joint.name for joint in conversion.mechanism.joints], ["left", "right"])
        self.assertIn("roll", notes(conversion, "lost"))
        self.assert_refused(hand, "no body wrists", "wrist, palm, left, right", root="wrists")

    def test_parts_that_are_planar_are_suggested(self):
        def finger(name: str, turn: float) -> str:
            tip = f'<body name="{name}_tip" pos="0.06 0 0"><joint name="{name}_tip" axis="0 -1 0"/>{LINK}</body>'
            return f'<body name="{name}" euler="0 0 {turn}"><joint name="{name}" axis="0 -1 0" damping="1e-4"/>{LINK}{tip}</body>'

        # Fingers that fan out: each is planar, with its own joint, its coupling and its drive.
        fingers = finger("left", 0.0) + finger("right", 0.4)
        rest = (
            '<equality><joint joint1="left_tip" joint2="left" polycoef="0 0.5 0 0 0"/><joint joint1="right_tip" joint2="right"/></equality>'
            '<actuator><motor name="l" joint="left"/><motor name="r" joint="right"/></actuator>'
        )
        hand = mjcf(f'<body name="palm" pos="0 0 0.1">{fingers}</body>', rest)
        self.assert_refused(hand, 'branch="left" (or branch="right")')
        conversion = convert(hand, branch="left", ctrl={"l": 0.02})
        self.assertEqual([joint.name for joint in conversion.mechanism.joints], ["left", "left_tip"])
        self.assertEqual((conversion.source.root, len(conversion.mechanism.couplings), len(conversion.mechanism.actuators)), ("palm", 1, 1))
        lost = notes(conversion, "lost")
        for item in ("joints outside of left: right, right_tip", "equality 1: it acts on joints outside of left", "actuator r"):
            self.assertIn(item, lost)
        found = free_motion(conversion.source, conversion.plane, conversion.mechanism, 0.05)
        self.assertLess(max(found.values()), RIGID)
        self.assert_refused(hand, "right of `branch` is not below left", root="left", branch=["right"])
        self.assert_refused(hand, "no body thumb; its bodies are palm, left", branch="thumb")
        # Parallel fingers are planar together.
        parallel = mjcf(f'<body name="palm"><joint name="roll" axis="0 0 1"/>{LINK}{finger("left", 0.0)}{finger("right", 0.0)}</body>', "")
        pair = convert(parallel, branch=["left", "right"])
        self.assertEqual([joint.name for joint in pair.mechanism.joints], ["left", "left_tip", "right", "right_tip"])
        # The last joint of an arm turns jaws in their own plane; their palm is the better root.
        jaws = "".join(f'<body name="{name}"><joint name="{name}" type="slide" axis="{x} 0 0"/>{LINK}</body>' for name, x in (("a", 1), ("b", -1)))
        arm = f'<body name="arm"><joint name="swing" axis="0 1 0"/>{LINK}<body name="wrist"><joint name="roll" axis="0 0 1"/>{LINK}'
        arm = mjcf(f'<body name="base">{arm}<body name="palm" pos="0 0 0.1">{jaws}</body></body></body></body>')
        self.assert_refused(arm, 'root="palm" (or root="arm")')

    def test_a_root_is_at_its_pose_of_the_key_frame(self):
        # The arm swings the palm by 0.5 rad, counter-clockwise, and rolls it about its own axis; a ball lies on the palm.
        arm = f'<body name="arm" pos="0.2 0 0.3"><joint name="swing" axis="0 -1 0"/>{LINK}<body name="wrist"><joint name="roll" axis="0 0 1"/>{LINK}'
        palm = (
            '<body name="palm" pos="0 0 0.1"><geom name="palm" type="box" size="0.05 0.05 0.01"/><body name="finger" pos="0.04 0'
            f' 0.02"><joint name="finger" axis="0 -1 0"/>{LINK}</body></body>'
        )
        ball = '<body name="ball" pos="0.2 0 0.5"><freejoint/><geom name="ball" type="sphere" size="0.02"/></body>'
        drives = '<actuator><motor name="arm" joint="swing"/><motor name="finger" joint="finger"/></actuator>'
        place = [0.2 - 0.15 * np.sin(0.5), 0, 0.3 + 0.15 * np.cos(0.5)]
        key = f'<keyframe><key name="raised" qpos="0.5 0 0.2 {" ".join(map(str, place))} 1 0 0 0" ctrl="3 0.01"/></keyframe>'
        text = mjcf(f"{arm}{palm}</body></body>{ball}", drives + key).replace('gravity="0 0 0"', 'gravity="0 0 -9.81"')
        conversion = convert(text, root="palm")
        np.testing.assert_allclose(conversion.mechanism.gravity, [-9.81 * np.sin(0.5), -9.81 * np.cos(0.5)], atol=1e-12)
        bodies = {body.name: body for body in conversion.mechanism.bodies}
        np.testing.assert_allclose(bodies["ball"].at, [0.0, 0.05], atol=1e-12)
        np.testing.assert_allclose(bodies["finger"].at, [0.04, 0.02], atol=1e-12)
        (joint,) = conversion.mechanism.joints
        self.assertEqual((joint.name, round(joint.start, 12)), ("finger", 0.2))
        (drive,) = conversion.mechanism.actuators
        self.assertEqual((drive.name, drive.effort), ("finger", 0.01))
        lost = notes(conversion, "lost")
        for name in ("joints outside of palm: swing, roll", "actuator arm: it acts on joints outside"):
            self.assertIn(name, lost)

    def test_name_what_a_scene_does_not_have(self):
        link = f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}</body><body name="b"><joint name="b" axis="0 -1 0"/>{LINK}</body>'
        polynomial = '<equality><joint name="cam" joint1="a" joint2="b" polycoef="0 1 0.2 0 0"/></equality>'
        self.assert_refused(mjcf(link, polynomial), "equality cam", "order 2")
        ball = f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}<body name="b"><joint name="b" type="ball"/>{LINK}</body></body>'
        self.assert_refused(mjcf(ball), "b is a ball joint")
        double = (
            f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}<body name="b"><joint name="x" type="slide" axis="1 0 0"/><joint name="y"'
            f' axis="0 -1 0"/>{LINK}</body></body>'
        )
        self.assert_refused(mjcf(double), "body b has 2 joints (x, y)")
        self.assert_refused(mjcf('<body name="a"><joint name="a" axis="0 -1 0"/></body>'), "MuJoCo does not read", "give the moving body an inertial")
        bare = "".join(f'<body name="{name}"><joint name="{name}" axis="0 -1 0"/></body>' for name in "xy")
        self.assert_refused(mjcf(link + bare), "give each of these moving bodies (x, y) an inertial")
        meshes = '<asset><mesh name="m" file="m.stl"/><mesh name="m" file="n.stl"/></asset>'
        self.assert_refused(mjcf(link, meshes), "repeated name", "give one of them another name")
        self.assert_refused(mjcf(link, '<default group="1"/>'), "unrecognized attribute", "remove this attribute")
        locked = '<equality><joint name="lock" joint1="a" polycoef="{} 0 0 0 0"/></equality>'
        self.assertEqual([joint.name for joint in convert(mjcf(link, locked.format(0))).mechanism.joints], ["b"])
        self.assert_refused(mjcf(link, locked.format(0.1)), "lock locks the joint a at 0.1")
        single = link.partition("</body>")[0] + "</body>"
        self.assert_refused(mjcf(single, locked.format(0)), "no joint of the mechanism moves", "locks joint a")
        self.assert_refused(mjcf(""), "no hinge or slide")
        self.assert_refused("<mujoco", "no XML file")
        self.assert_refused("<mujocoinclude/>", "is a part of a model", "give the file that includes it")
        self.assert_refused("<sdf/>", "neither MJCF nor URDF", "<sdf>")
        self.assert_refused(mjcf(link, '<contact><exclude body1="a" body2="z"/></contact>'), "if the file is a part of a larger model")
        self.assert_refused(mjcf(link), "no key frame open", key="open")
        self.assert_refused(mjcf(link), "no actuator motor", ctrl={"motor": 1.0})
        unnamed = convert(mjcf(link, '<actuator><motor joint="a"/></actuator>'), ctrl={"0": 0.5})
        self.assertEqual([(drive.name, drive.effort) for drive in unnamed.mechanism.actuators], [("actuator_0", 0.5)])
        self.assert_refused(mjcf(link), "no plane 'xw'", plane="xw")
        ball = '<body name="ball" pos="0 0 0.3"><freejoint/><geom size="0.02"/></body>'
        self.assert_refused(mjcf(link + ball), "a free body already (ball)", cube=0.04)
        self.assertIn("the cube: it touches nothing", notes(convert(mjcf(link), cube=0.04), "warning"))

    def test_without_mujoco_name_the_command(self):
        with mock.patch.dict(sys.modules, {"mujoco": None}), self.assertRaises(ImportError) as raised:
            convert(mjcf(""))
        self.assertIn('pip install "phalanx[mujoco]"', str(raised.exception))


def at_rest(text: str, *, steps: int = 40_000) -> tuple[object, object]:
    """A model of MuJoCo and its data after a long time."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_step(model, data, nstep=steps)
    return model, data


@unittest.skipIf(mujoco is None, "needs mujoco")
class Contacts(unittest.TestCase):
    def test_laws_have_the_stiffness_of_mujocos_penetration(self):
        settings = 'condim="{}" friction="{} 0.005 0.0001" solref="{} 1" solimp="0.9 0.97 0.002 0.5 2"'
        cones = (
            ("elliptic", 3, 0.8, 1),
            ("pyramidal", 1, 0.8, 1),
            ("pyramidal", 3, 0.8, 1),
            ("pyramidal", 3, 0.5, 10),
            ("pyramidal", 4, 1.2, 2),
        )
        shapes = (('type="sphere" size="0.01"', 1), ('type="box" size="0.02 0.01 0.01"', 4))
        for (geom, points), timeconst, (cone, condim, mu, impratio) in itertools.product(shapes, (0.004, 0.02), cones):
            with self.subTest(geom=geom, timeconst=timeconst, cone=cone, condim=condim):
                own = settings.format(condim, mu, timeconst)
                joint = '<joint name="lift" type="slide" axis="0 0 1" damping="20"/>'
                pad = f'<body name="pad" pos="0 0 0.0105">{joint}{LINK}<geom name="pad" {geom} mass="0" {own}/></body>'
                text = mjcf(
                    f'<geom name="floor" type="plane" size="1 1 1" {own}/>{pad}',
                    f'<actuator><motor name="m" joint="lift"/></actuator><keyframe><key qpos="0" ctrl="{-10 * points}"/></keyframe>',
                ).replace("<option", f'<option timestep="0.0005" cone="{cone}" impratio="{impratio}"')
                conversion = convert(text)
                contact = next(contact for contact in conversion.mechanism.contacts if set(contact.between) == {"ground.floor", "pad.pad"})
                law = next(law for law in conversion.mechanism.laws if law.name == contact.law)
                # A load of 10 N on each point in space; four of them are two of the plane.
                _, data = at_rest(text)
                depth = -min(c.dist for c in data.contact)
                planar_points = 1 if points == 1 else 2
                self.assertLess(abs(10 * points / (planar_points * law.stiffness * depth) - 1), 0.006)

    def test_stops_have_the_stiffness_of_mujocos_limits(self):
        for kind, axis, load in (("hinge", "0 -1 0", 1.0), ("slide", "1 0 0", 1.0)):
            with self.subTest(kind=kind):
                joint = (
                    f'<joint name="j" type="{kind}" axis="{axis}" damping="0.05" armature="1e-4" limited="true" range="-0.1 0.01"'
                    ' solreflimit="0.004 1" solimplimit="0.95 0.99 0.001"/>'
                )
                text = mjcf(
                    f'<body name="link">{joint}{LINK}</body>',
                    f'<actuator><motor name="m" joint="j"/></actuator><keyframe><key qpos="0" ctrl="{load}"/></keyframe>',
                )
                conversion = convert(text)
                _, data = at_rest(text)
                stiffness = conversion.mechanism.laws[0].stiffness
                self.assertLess(abs(load / (stiffness * (data.qpos[0] - 0.01)) - 1), 0.006)
                result = phalanx.run(conversion.scene, duration=0.5)
                column_of = "j_rad" if kind == "hinge" else "j_position_m"
                self.assertAlmostEqual(result[column_of][-1], data.qpos[0], delta=0.006 * load / stiffness)

    def test_stops_of_a_tendon_of_one_joint(self):
        link = f'<body name="link"><joint name="j" axis="0 -1 0" damping="0.05" armature="1e-4"/>{LINK}</body>'
        settings = 'limited="true" range="-1 0.03" solreflimit="0.004 1" solimplimit="0.95 0.99 0.001"'
        tendon = f'<tendon><fixed name="t" {settings}><joint joint="j" coef="-3"/></fixed></tendon>'
        text = mjcf(link, f'{tendon}<actuator><motor name="m" joint="j"/></actuator><keyframe><key qpos="0" ctrl="-1"/></keyframe>')
        conversion = convert(text)
        (joint,) = conversion.mechanism.joints
        self.assertAlmostEqual(joint.lower, -0.01, delta=1e-15)
        _, data = at_rest(text)
        self.assertLess(abs(1.0 / (conversion.mechanism.laws[0].stiffness * (-0.01 - data.qpos[0])) - 1), 0.006)

    def test_cables_are_taut_at_the_end_of_their_range(self):
        settings = 'limited="true" range="0 0.05" solreflimit="0.01 1" solimplimit="0.9 0.95 0.001"'
        # A load of 1 N on the tendon of MuJoCo, for which the law is exact.
        for branch, divisor, weight in (("", 1, 1.0), ('<pulley divisor="2"/>', 2, 0.5)):
            with self.subTest(divisor=divisor):
                # A ball hangs from a point; MuJoCo's length is that of the branch over the divisor.
                ball = (
                    '<site name="top" pos="0 0 0.3"/><body name="ball" pos="0 0 {}"><freejoint/><geom name="ball" size="0.01" mass="{}"/><site'
                    ' name="eye"/></body><body name="a" pos="1 0 0"><joint name="a" axis="0 -1 0"/>{}</body>'
                ).format(0.3 - 0.05 * divisor, weight / 9.81, LINK)
                tendon = f'<tendon><spatial name="t" {settings}>{branch}<site site="top"/><site site="eye"/></spatial></tendon>'
                text = mjcf(ball, f'{tendon}<keyframe><key qpos="0 0 {0.3 - 0.05 * divisor} 1 0 0 0 0"/></keyframe>')
                text = text.replace('gravity="0 0 0"', 'gravity="0 0 -9.81" timestep="0.0005"')
                conversion = convert(text, duration=0.5)
                (cable,) = conversion.mechanism.tendons
                self.assertAlmostEqual(cable.rest, 0.05 * divisor, delta=1e-15)
                _, data = at_rest(text)
                stretch = 0.3 - 0.05 * divisor - data.body("ball").xpos[2]
                expected = weight / cable.stiffness
                self.assertLess(abs(stretch / expected - 1), 0.006)
                result = phalanx.run(conversion.scene)
                self.assertAlmostEqual(result["ball_y_m"][-1], 0.3 - 0.05 * divisor - expected, delta=0.02 * expected)
                self.assertIn("tendon t: the upper end of its range", notes(conversion, "changed"))

    def test_tables_do_not_belong_to_the_hand(self):
        slide = '<joint name="{0}" type="slide" axis="{1} 0 0"/><geom name="{0}" type="box" size="0.006 0.012 0.045" pos="0 0 0.045" mass="0.05"/>'
        fingers = "".join(
            f'<body name="{name}" pos="{x} 0 0.02">{slide.format(name, sign)}</body>' for name, x, sign in (("l", -0.04, 1), ("r", 0.04, -1))
        )
        palm = '<geom name="palm" type="box" size="0.06 0.03 0.02" mass="0.5"/>'
        cube = '<body name="cube" pos="0 0 0.02"><freejoint/><geom name="cube" type="box" size="0.02 0.02 0.02" mass="0.1"/></body>'
        table = '<body name="desk"><geom name="table" type="box" size="1 1 0.1" pos="0 0 -0.1"/></body>'
        conversion = convert(mjcf(f'{table}<body name="base" pos="0 0 0.14" quat="0 1 0 0">{palm}{fingers}</body>{cube}'))
        self.assertIn('[grasp]\nsurroundings = ["ground.table"]', conversion.toml)
        # Fingers that slide along the palm do not touch it.
        self.assertIn("ground.palm and l.l (0 mm)", notes(conversion, "lost"))
        touching = {frozenset(contact.between) for contact in conversion.mechanism.contacts}
        self.assertIn(frozenset(("ground.palm", "cube.cube")), touching)
        self.assertNotIn(frozenset(("ground.palm", "l.l")), touching)
        mount = f'<body name="mount" pos="0 0 0.14"><geom name="flange" type="box" size="0.1 0.1 0.01"/><body name="base" quat="0 1 0 0">{palm}{fingers}</body></body>'
        self.assertEqual(convert(mjcf(f"{mount}{cube}")).mechanism.surroundings, [])
        plane = mjcf(f'<geom name="floor" type="plane" size="1 1 1"/>{palm.replace("0.5", "0")}{fingers}{cube}')
        self.assertEqual(convert(plane).mechanism.surroundings, ["ground.floor"])

    def test_shapes_are_projected(self):
        turn = 'euler="0 -0.5235987755982988 0"'
        geoms = (
            '<geom name="sphere" type="sphere" size="0.01"/><geom name="rod" type="capsule" fromto="0 0 0 0.03 0.04 0.02"'
            ' size="0.005"/><geom name="end on" type="capsule" fromto="0 -0.01 0 0 0.01 0" size="0.005"/><geom name="disc" type="cylinder"'
            ' fromto="0 -0.01 0 0 0.01 0" size="0.02"/><geom name="lying" type="cylinder" fromto="0 0 0 0.04 0 0" size="0.003"/><geom'
            f' name="box" type="box" {turn} size="0.03 0.02 0.01"/><geom name="corner" type="box" euler="0 0 0.7853981633974483" size="0.02'
            f' 0.02 0.01"/><geom name="egg" type="ellipsoid" {turn} size="0.03 0.02 0.01"/><geom name="wedge" type="mesh" mesh="wedge"/>'
        )
        assets = '<asset><mesh name="wedge" vertex="0 -0.01 0  0.04 -0.01 0  0 -0.01 0.03  0 0.01 0  0.04 0.01 0  0 0.01 0.03"/></asset>'
        conversion = convert(
            mjcf(
                f'<geom name="floor" type="plane" size="1 1 1" pos="0 0 -1"/><body name="link"><joint name="pin" axis="0 -1 0"/>{geoms}</body>',
                assets,
            )
        )
        (body,) = conversion.mechanism.bodies
        found = {outline.name: outline for outline in body.outlines}
        self.assertEqual({name: outline.type for name, outline in found.items()}, {
            "sphere": "disc", "rod": "capsule", "end_on": "disc", "disc": "disc", "lying": "box", "box": "box",
            "corner": "polygon", "egg": "ellipse", "wedge": "polygon",
        })  # fmt: skip
        np.testing.assert_allclose(sorted(found["rod"].points), [[0, 0], [0.03, 0.02]], atol=1e-9)
        np.testing.assert_allclose(found["box"].sizes, [0.06, 0.02], atol=1e-12)
        self.assertAlmostEqual(found["box"].angle, np.pi / 6, delta=1e-9)
        np.testing.assert_allclose(found["lying"].sizes, [0.04, 0.006], atol=1e-9)
        np.testing.assert_allclose(found["egg"].sizes, [0.03, 0.01], atol=1e-9)
        self.assertAlmostEqual(found["egg"].angle, np.pi / 6, delta=1e-9)
        # Turned by 45 deg about z, the box is 2 sqrt(2) 20 mm wide in the plane.
        corners = np.array(found["corner"].points)
        self.assertAlmostEqual(np.ptp(corners[:, 0]) + 2 * found["corner"].rounding, 0.04 * 2**0.5, delta=2e-8)
        wedge = np.array(found["wedge"].points)
        self.assertEqual(len(wedge), 3)
        self.assertAlmostEqual(wedge[:, 0].min() - found["wedge"].rounding, 0.0, delta=2e-7)
        np.testing.assert_allclose(found["wedge"].depth, [-0.01, 0.01], atol=1e-6)
        (floor,) = conversion.mechanism.ground
        self.assertEqual((floor.type, floor.points, floor.sizes), ("half_plane", [(0.0, -1.0)], (0.0, 1.0)))
        phalanx.run(conversion.scene, duration=1e-3)

    def test_pairs_are_those_of_mujoco(self):
        def link(name: str, x: float, geom: str, y: float = 0.0) -> str:
            return (
                f'<body name="{name}" pos="{x} {y} 0"><joint name="{name}" axis="0 -1 0"/>{LINK}<geom name="{name}" type="sphere"'
                f' size="0.01" {geom}/></body>'
            )

        ball = '<body name="ball" pos="0.3 0 0.2"><freejoint/><geom name="ball" type="sphere" size="0.02" friction="0.5" priority="{}"/></body>'
        world = link("a", 0, 'friction="0.8"') + link("b", 0.1, 'contype="0" conaffinity="0"') + link("c", 0.2, "") + link("d", 0.3, 'friction="0.3"')
        world += link("e", 0, "", y=0.1) + link("f", 0.005, "")
        rest = '<contact><exclude body1="a" body2="c"/><pair geom1="b" geom2="d" friction="0.4 0.4 0 0 0"/></contact>'
        for priority, friction in ((0, 0.8), (1, 0.5)):
            conversion = convert(mjcf(world + ball.format(priority), rest))
            pairs = {frozenset(name.split(".")[0] for name in contact.between): contact.law for contact in conversion.mechanism.contacts}
            touching = {frozenset(pair) for pair in ("ad", "cd", "cf", "df", "bd")}
            touching |= {frozenset((name, "ball")) for name in "acdef"}
            self.assertEqual(set(pairs), touching)
            laws = {law.name: law.friction for law in conversion.mechanism.laws}
            self.assertEqual(laws[pairs[frozenset(("a", "ball"))]], friction)
            self.assertEqual(laws[pairs[frozenset("bd")]], 0.4)
            lost = notes(conversion, "lost")
            self.assertIn("a.a and f.f (15 mm)", lost)
            self.assertIn("a.a and e.e", lost)

    def test_an_ellipse_of_the_hand_becomes_a_polygon_for_another_ellipse(self):
        egg = '<geom name="{}" type="ellipsoid" size="0.02 0.02 0.03"/>'
        finger = f'<body name="a"><joint name="a" type="slide" axis="1 0 0"/>{LINK}{egg.format("tip")}</body>'
        conversion = convert(mjcf(f'{finger}<body name="egg" pos="0.05 0 0"><freejoint/>{egg.format("skin")}</body>'), plane="xz")
        tip, skin = (body.outlines[0] for body in conversion.mechanism.bodies)
        self.assertEqual((tip.type, len(tip.points), skin.type), ("polygon", 32, "ellipse"))
        # The shape does not change: half the width of the ellipse, up to its facets.
        self.assertAlmostEqual(max(x for x, _ in tip.points) + tip.rounding, 0.02, delta=2e-4)
        self.assertEqual([set(contact.between) for contact in conversion.mechanism.contacts], [{"a.tip", "egg.skin"}])
        self.assertIn("a.tip: a polygon of 32 corners", notes(conversion, "changed"))
        phalanx.run(conversion.scene, duration=1e-3)

    def test_the_nearest_pairs_are_kept_where_there_are_too_many(self):
        points = np.random.default_rng(0).normal(size=(200, 3))
        points *= 0.02 / np.linalg.norm(points, axis=1, keepdims=True)
        mesh = f'<asset><mesh name="ball" vertex="{" ".join(f"{value:.6f}" for value in points.ravel())}"/></asset>'
        balls = "".join(f'<body name="ball_{k}" pos="{0.06 * k} 0 0.2"><freejoint/><geom type="mesh" mesh="ball"/></body>' for k in range(8))
        conversion = convert(mjcf(f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}</body>{balls}', mesh))
        pairs = {frozenset(int(name[5]) for name in contact.between) for contact in conversion.mechanism.contacts}
        self.assertTrue(pairs > {frozenset((k, k + 1)) for k in range(7)})
        self.assertLess(len(pairs), 28)
        self.assertIn("contacts beyond the largest number", notes(conversion, "lost"))
        phalanx.run(conversion.scene, duration=1e-3)


URDF = """<robot name="jaws">
  <link name="world"/>
  <joint name="mount" type="fixed"><parent link="world"/><child link="base"/><origin xyz="0 0 0.1"/></joint>
  <link name="base"><visual><geometry><mesh filename="package://jaws/base.dae"/></geometry></visual></link>
  {}
</robot>"""
URDF_LINK = """<joint name="{0}" type="revolute"><parent link="base"/><child link="{0}"/><origin xyz="{1} 0 0"/><axis xyz="0 -1 0"/>
  <limit lower="-1" upper="1" effort="3" velocity="2"/><dynamics damping="0.01" friction="0.02"/>{2}</joint>
  <link name="{0}"><inertial><mass value="0.02"/><origin xyz="0.03 0 0.01"/>
    <inertia ixx="1e-5" iyy="2e-5" izz="2e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{0}_tip" type="fixed"><parent link="{0}"/><child link="{0}_tip"/><origin xyz="0.06 0 0"/></joint>
  <link name="{0}_tip"><inertial><mass value="0.01"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.02 0.02 0.01"/></geometry></collision></link>"""


@unittest.skipIf(mujoco is None, "needs mujoco")
class Reports(unittest.TestCase):
    def test_urdf_with_a_mimic_joint(self):
        left = URDF_LINK.format("left", -0.02, "")
        right = URDF_LINK.format("right", 0.02, '<mimic joint="left" multiplier="-0.5" offset="0.2"/>')
        with tempfile.TemporaryDirectory() as directory:
            path = Path(directory) / "jaws.urdf"
            path.write_text(URDF.format(left + right))
            conversion = phalanx.from_mjcf(path)
        bodies = {body.name: body for body in conversion.mechanism.bodies}
        self.assertEqual(bodies["left"].members, ["left", "left_tip"])
        self.assertAlmostEqual(bodies["left"].mass, 0.03, delta=1e-12)
        np.testing.assert_allclose(bodies["left"].com, [0.04, 0.02 / 3], atol=1e-12)
        # Steiner: 20 g at (30, 10) mm and 10 g at (60, 0) mm.
        self.assertAlmostEqual(bodies["left"].inertia, 2e-5 + 1e-6 + 0.02 * 0.01 / 0.03 * 1e-3, delta=1e-12)
        (coupling,) = conversion.mechanism.couplings
        self.assertEqual((coupling.terms, coupling.value), ([("right", 1.0), ("left", 0.5)], 0.2))
        result = phalanx.run(conversion.scene, duration=1e-3)
        self.assertAlmostEqual(result["right_rad"][0] + 0.5 * result["left_rad"][0], 0.2, delta=1e-12)
        self.assertIn("base.dae", notes(conversion, "lost") + "base.dae")
        self.assertIn("velocity limits: the joints may turn faster than left 2, right 2", notes(conversion, "lost"))
        self.assertIn("meshes of body base", notes(conversion, "lost"))
        self.assertIn("violated by 0.2", notes(conversion, "changed"))
        self.assertIn(
            "the scene has none: add a section [actuators.NAME] (largest efforts of the model: left 3, right 3", notes(conversion, "warning")
        )

    def test_every_dropped_item_is_named(self):
        links = "".join(
            f'<body name="{name}" pos="{x} 0 0"><joint name="{name}" axis="0 -1 0"/>{LINK}<site name="{name}"/></body>'
            for name, x in (("a", 0), ("b", 0.1), ("c", 0.2))
        )
        stiff = (
            f'<body name="d" pos="0.3 0 0" gravcomp="1"><joint name="d" axis="0 -1 0" range="0.1 1" margin="0.01"/>{LINK}<geom'
            ' name="terrain" type="ellipsoid" size="0.02 0.01 0.01" condim="4"/></body>'
        )
        ball = '<body name="ball" pos="0.6 0 0"><freejoint name="free"/><geom name="ball" type="sphere" size="0.02" mass="0.1"/></body>'
        rest = (
            '<tendon><fixed name="slack" frictionloss="0.1" stiffness="2" springlength="0.1 0.3"><joint'
            ' joint="a" coef="1"/></fixed><spatial name="ruler" limited="true" range="0.01 1"><site site="a"/><site site="b"/></spatial></tendon><equality><connect'
            ' name="idle" body1="a" body2="b" anchor="0 0 0" active="false"/><tendon name="reel"'
            ' tendon1="ruler"/></equality><actuator><general name="push" site="a" gear="1 0 0 0 0 0"/><muscle name="arm" joint="a"'
            ' lengthrange="0 1"/><position name="slow" joint="b" timeconst="0.1"/><position name="winch" tendon="ruler" forcerange="-2 2"/><motor'
            ' name="shove" tendon="ruler"/><general name="runaway" joint="c" biastype="affine" biasprm="0 2 0"/></actuator><keyframe><key'
            ' name="start" qpos="0 0 0 0 0.6 0 0 1 0 0 0" ctrl="0 0 0 0 3 0"/></keyframe>'
        )
        world = '<geom name="wall" type="plane" size="1 1 1" euler="0.3 0 0" pos="0 0 -3"/>' + links + stiff + ball
        conversion = convert(mjcf(world, rest).replace('gravity="0 0 0"', 'gravity="0 -9.81 -1" density="1.2"'))
        lost = notes(conversion, "lost")
        for item in (
            "gravity: its part of 9.81", "body d: its gravity compensation", "joint d: its lower limit of 0.1", "joint d: the margin of its limits",
            "tendon ruler: the lower end of its range, 0.01 m", "tendon slack: its frictionloss", "tendon slack: its spring has a dead band from 0.1 to 0.3",
            "equality idle: it is not active", "equality reel: it acts on a spatial tendon",
            "actuator push: its transmission site", "actuator arm: mjGAIN_MUSCLE", "actuator slow: its activation dynamics (filterexact, 0.1 s)",
            "actuator winch: its forcerange of -2 to 2", "actuator shove: at ctrl 3 it pushes with 3 N", "actuator runaway: its bias grows",
            "geom wall: a plane geom", "torsional and rolling friction", "option density: fluid forces",
        ):  # fmt: skip
            self.assertIn(item, lost)
        for note in conversion.report.of("lost"):
            self.assertIn(note.name.partition(" ")[0], conversion.toml.partition("\nkind")[0])

    def test_ranges_of_tendons_are_limits_of_sums(self):
        link = f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}</body><body name="b"><joint name="b" axis="0 -1 0"/>{LINK}</body>'
        tendon = '<tendon><fixed name="t" limited="true" range="-1 0.5"><joint joint="a" coef="2"/><joint joint="b" coef="-1"/></fixed></tendon>'
        conversion = convert(mjcf(link, tendon))
        (limit,) = conversion.mechanism.limits
        self.assertEqual((limit.terms, limit.lower, limit.upper, limit.stop), ([("a", 2.0), ("b", -1.0)], -1.0, 0.5, "stop"))
        section = '[limits.t]    # range of a tendon\njoints = ["a", "b"]\nfactors = [2, -1]\nlower = "-1 rad"\nupper = "0.5 rad"\nstop = "stop"\n'
        self.assertIn(section, conversion.toml)
        self.assertNotIn("range", notes(conversion, "lost"))
        phalanx.run(conversion.scene, duration=1e-3)
        # A tendon of one joint limits this joint, in the other direction if its factor is negative.
        single = tendon.replace('<joint joint="a" coef="2"/>', "").replace('coef="-1"', 'coef="-2"')
        (joint,) = (joint for joint in convert(mjcf(link, single)).mechanism.joints if joint.stop)
        self.assertEqual((joint.name, joint.lower, joint.upper), ("b", -0.25, 0.5))

    def test_ranges_of_fixed_sums_have_no_effect(self):
        links = "".join(f'<body name="{name}"><joint name="{name}" axis="0 -1 0"/>{LINK}</body>' for name in "abc")
        terms = '<joint joint="a" coef="2"/><joint joint="b" coef="-1"/>'
        rest = (
            f'<tendon><fixed name="t" limited="true" range="0 1">{terms}</fixed><fixed name="free" limited="true" range="-1 1"><joint joint="a" coef="1"/>'
            '<joint joint="c" coef="1"/></fixed></tendon><equality><tendon tendon1="t"/></equality>'
        )
        conversion = convert(mjcf(links, rest))
        self.assertEqual([limit.name for limit in conversion.mechanism.limits], ["free"])
        self.assertIn("tendon t: its range of 0 to 1 has no effect, because equalities fix its length at 0", notes(conversion, "changed"))

    def test_a_tendon_narrows_the_range_of_its_joint(self):
        link = f'<body name="a"><joint name="a" axis="0 -1 0" range="-1 1" limited="true"/>{LINK}</body>'
        tendon = '<tendon><fixed name="t" limited="true" range="-1.6 4"><joint joint="a" coef="-2"/></fixed></tendon>'
        conversion = convert(mjcf(link, tendon))
        (joint,) = conversion.mechanism.joints
        self.assertEqual((joint.lower, joint.upper, len(conversion.mechanism.laws)), (-1.0, 0.8, 1))
        self.assertIn("tendon t: its range is the upper limit of the joint a", notes(conversion, "changed"))
        self.assertNotIn("range", notes(conversion, "lost"))

    def test_springs_with_a_dead_band_are_elastic_limits(self):
        link = f'<body name="b" pos="0.06 0 0"><joint name="b" axis="0 -1 0"/>{LINK}</body>'
        link = f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}{link}</body>'
        drives = '<actuator><motor name="m" joint="a"/><motor name="n" joint="b"/></actuator>'
        for factors, sign in itertools.product(((2, -1), (1.5,), (-1.5,)), (1, -1)):
            with self.subTest(factors=factors, sign=sign):
                terms = "".join(f'<joint joint="{name}" coef="{factor}"/>' for name, factor in zip("ab", factors, strict=False))
                tendon = f'<tendon><fixed name="t" stiffness="0.3" springlength="-0.1 0.2">{terms}</fixed></tendon>'
                conversion = convert(mjcf(link, tendon + drives), ctrl={"m": 0.02 * sign, "n": -0.005 * sign}, duration=0.1)
                self.assertIn("its spring has a dead band from -0.1 to 0.2: it is a pair of limits", notes(conversion, "changed"))
                found = free_motion(conversion.source, conversion.plane, conversion.mechanism, 0.1)
                # RK4 with a fixed step crosses the ends of the band.
                self.assertLess(max(found.values()), 1e-6)
                self.assertGreater(np.ptp(phalanx.run(conversion.scene)["a_rad"]), 0.1)

    def test_a_servo_of_the_length_of_a_cable_is_its_spring(self):
        tip = f'<body name="b" pos="0.06 0 0"><joint name="b" axis="0 -1 0" stiffness="0.02"/>{LINK}<site name="tip" pos="0.05 0 0.015"/></body>'
        pulley = '<geom name="pulley" type="cylinder" fromto="0.03 -0.01 0 0.03 0.01 0" size="0.008" contype="0" conaffinity="0" mass="0"/>'
        pulley += '<site name="side" pos="0.03 0 0.03"/><site name="peg" pos="0.06 0 0.02"/>'
        world = f'<site name="base" pos="-0.03 0 0.02"/><body name="a"><joint name="a" axis="0 -1 0" damping="2e-3"/>{LINK}{pulley}{tip}</body>'
        path = '<site site="base"/><geom geom="pulley" sidesite="side"/><site site="peg"/><site site="tip"/>'
        for branch, divisor, ctrl, duration in ((path, 1, 0.17, 0.05), ('<pulley divisor="2"/><site site="base"/><site site="tip"/>', 2, 0.085, 0.02)):
            with self.subTest(divisor=divisor):
                servo = '<actuator><position name="s" tendon="t" kp="60" kv="0.5" gear="2"/></actuator>'
                conversion = convert(mjcf(world, f'<tendon><spatial name="t">{branch}</spatial></tendon>{servo}'), ctrl={"s": ctrl})
                (tendon,) = conversion.mechanism.tendons
                expected = (240 / divisor**2, 2 / divisor**2, 0.085)
                np.testing.assert_allclose((tendon.stiffness, tendon.damping, tendon.rest), expected, rtol=1e-12)
                self.assertLess(max(free_motion(conversion.source, conversion.plane, conversion.mechanism, duration).values()), RIGID)
                self.assertGreater(np.ptp(phalanx.run(conversion.scene, duration=duration)["b_rad"]), 0.5)
                self.assertIn("actuator s: a servo of the length of a cable is the spring of t", notes(conversion, "changed"))
        # A pulley between two sites of its own body adds a constant to the length, which matters to a servo only.
        path = '<site site="base"/><site site="peg"/><geom geom="pulley" sidesite="side"/><site site="lug"/><site site="tip"/>'
        world = world.replace(tip, f'<site name="lug" pos="0.005 0 -0.02"/>{tip}')
        lengths = {}
        for drive, count in (('<position name="s" tendon="t" kp="60"/>', 5), ('<motor name="s" tendon="t"/>', 4)):
            conversion = convert(mjcf(world, f'<tendon><spatial name="t">{path}</spatial></tendon><actuator>{drive}</actuator>'), ctrl={"s": 0.1})
            self.assertEqual(len(conversion.mechanism.tendons[0].path), count)
            lengths[count] = phalanx.run(conversion.scene, duration=1e-4)["t_length_m"][0]
        self.assertAlmostEqual(lengths[5], conversion.source.zero.ten_length[0], delta=1e-12)
        self.assertGreater(lengths[5] - lengths[4], 1e-4)

    def test_an_integrator_keeps_its_activation(self):
        link = f'<body name="a"><joint name="a" axis="0 -1 0"/>{LINK}</body><body name="b"><joint name="b" axis="0 -1 0"/>{LINK}</body>'
        drives = '<actuator><motor name="m" joint="b"/><intvelocity name="i" joint="a" kp="2" actrange="-1 1"/></actuator>'
        key = '<keyframe><key qpos="0 0" ctrl="0.1 0.3" act="0.25"/></keyframe>'
        for root in (None, "a"):
            world = link if root is None else f'<body name="arm"><joint name="arm" axis="1 0 0"/>{LINK}{link}</body>'
            pose = key if root is None else key.replace('qpos="0 0"', 'qpos="0 0 0"')
            conversion = convert(mjcf(world, drives + pose), root=None if root is None else "arm")
            drive = next(drive for drive in conversion.mechanism.actuators if drive.name == "i")
            self.assertEqual((drive.target, drive.kp), (0.25, 2.0))
            self.assertIn("actuator i: its activation integrates", notes(conversion, "lost"))

    def test_pulleys_that_the_cable_does_not_touch(self):
        text = next(path for path in MODELS if path.stem == "spatial-tendon").read_text()
        text = text.replace('name="winch" pos="-0.04 0 0.02"', 'name="winch" pos="-0.04 0 -0.03"').replace(
            'name="hole" pos="0.04 0 0.03"', 'name="hole" pos="0.04 0 -0.03"'
        )
        conversion = convert(text)
        path = next(tendon.path for tendon in conversion.mechanism.tendons if len(tendon.path) == 3)
        self.assertEqual((path[1].radius, path[1].turn), (0.008, "ccw"))
        phalanx.run(conversion.scene, duration=1e-3)

    def test_missing_textures_and_impossible_inertias_do_not_matter(self):
        assets = '<asset><texture name="t" type="2d" file="missing.png"/><material name="m" texture="t"/></asset>'
        impossible = '<inertial pos="0.03 0 0" mass="0.02" diaginertia="1e-6 2e-6 6e-6"/><geom size="0.01" material="m"/>'
        conversion = convert(mjcf(f'<body name="a"><joint name="a" axis="0 -1 0"/>{impossible}</body>', assets))
        self.assertAlmostEqual(conversion.mechanism.bodies[0].inertia, 3e-6, delta=1e-15)
        self.assertIn("body a: the largest moment of inertia exceeds the sum", notes(conversion, "warning"))
        self.assertEqual(notes(conversion, "lost"), "")

    def test_suspicious_models_are_named(self):
        fragment = f'<mujoco><worldbody><body name="a"><joint name="a" axis="0 1 0" range="0 0.7"/>{LINK}</body></worldbody></mujoco>'
        self.assertIn("ranges of hinges: all are below 5 deg", notes(convert(fragment), "warning"))
        placeholder = '<inertial pos="0 0 0" mass="0.001" diaginertia="1e-3 1e-3 1e-3"/><geom name="pad" type="box" size="0.02 0.01 0.01" mass="0"/>'
        text = notes(convert(mjcf(f'<body name="a"><joint name="a" axis="0 1 0" armature="0.2"/>{placeholder}</body>')), "warning")
        self.assertIn("body a: its radius of gyration is 1e+03 mm, but its extent", text)
        self.assertIn("body a: its centre of mass is exactly in its joint", text)
        self.assertIn("joint a: its armature of 0.2 kg m^2 is 200 times", text)
        rubbing = mjcf(
            f'<body name="a"><joint name="a" axis="0 1 0" frictionloss="1"/>{LINK}<geom name="pad" type="box" size="0.05 0.01 0.01" mass="0"/>'
            '<body name="coupler"><inertial pos="0 0 0" mass="1e-3" diaginertia="1e-8 1e-8 1e-8"/></body></body>'
        )
        self.assertIn("joint a: its frictionloss of 1 N m is 48 times the weight", notes(convert(rubbing), "warning"))
        self.assertIn("body a: coupler has no joint that moves, and is a part of it", notes(convert(rubbing), "changed"))
        visual = (
            '<body name="a"><joint name="a" axis="0 1 0"/><geom type="box" size="0.02 0.01 0.01" pos="0.02 0 0" contype="0" conaffinity="0"/></body>'
        )
        self.assertIn("body a: all of its mass of 16 g comes from visual geoms", notes(convert(mjcf(visual)), "warning"))
        degrees = f'<body name="a"><joint name="a" axis="0 1 0"/>{LINK}</body>'
        servo = '<actuator><position name="s" joint="a" kp="1" ctrlrange="0 90"/></actuator>'
        self.assertIn("actuator s: its ctrlrange ends at 90", notes(convert(mjcf(degrees, servo)), "warning"))
        clipped = notes(convert(mjcf(degrees, servo), ctrl={"s": 100}), "changed")
        self.assertIn("actuator s: its control signal of 100 is outside of its ctrlrange of 0 to 90, and is 90 in the scene", clipped)
        tilted = convert(
            mjcf(
                f'<body name="a"><joint name="a" axis="0 1 0"/>{LINK}<body name="b" pos="0.1 0 0"><joint name="b" axis="0.01 1'
                f' 0"/>{LINK}</body></body>'
            )
        )
        self.assertIn("its axis is tilted by 0.29 deg", notes(tilted, "warning"))


@unittest.skipIf(mujoco is None, "needs mujoco")
class Commands(unittest.TestCase):
    def test_a_gripper_holds_a_cube(self):
        with tempfile.TemporaryDirectory() as directory:
            model, out = Path(directory) / "hand.xml", Path(directory) / "my-gripper.toml"
            franka = next(path for path in MODELS if path.stem == "franka").read_text()
            # A stiff servo, so that the force is that of its limit.
            model.write_text(franka.replace('forcerange="-100 100"', 'forcerange="-20 20"').replace("0 -100 -10", "0 -10000 -100"))
            call = [sys.executable, "-m", "phalanx.convert", model, "--cube", "30", "--ctrl", "fingers=0", "--out", out]
            result = subprocess.run(list(map(str, call)), capture_output=True, text=True, check=False)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("wrote", result.stdout)
            self.assertIn("held since", command("run", out, "--no-check"))
            again = subprocess.run(list(map(str, call)), capture_output=True, text=True, check=False)
            self.assertEqual(again.returncode, 2)
            self.assertIn("--force", again.stderr)
            comparison = phalanx.compare_mujoco(model, ctrl={"fingers": 0.0}, cube=0.03)
            same = phalanx.compare_mujoco(phalanx.from_mjcf(model, ctrl={"fingers": 0.0}, cube=0.03))
        self.assertEqual(str(same), str(comparison))
        self.assertTrue(comparison.phalanx.held)
        self.assertEqual(comparison.phalanx.first_touch.keys(), comparison.mujoco.first_touch.keys())
        for pair, first in comparison.phalanx.first_touch.items():
            self.assertAlmostEqual(first, comparison.mujoco.first_touch[pair], delta=4e-3)
        # Two boxes of a finger share its force, by 20 µm of penetration.
        forces = [sum(side.presses.values()) for side in (comparison.phalanx, comparison.mujoco)]
        self.assertAlmostEqual(forces[0], forces[1], delta=0.01 * forces[0])
        self.assertLess(comparison.phalanx.creep, 1e-9)
        self.assertGreater(comparison.mujoco.openings["joint mimic, m"], 0.0)
        self.assertIn("held at the end", str(comparison))


if __name__ == "__main__":
    unittest.main()
