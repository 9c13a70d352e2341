"""Scenes are read, changed and validated."""

import copy
import json
import pickle
import tomllib
import unittest

import jsonschema
import numpy as np
import phalanx
from common import ANCHOR, DISCS, GRIPPER, ROOT, SCENES, command


class Scenes(unittest.TestCase):
    def test_scene_text_equals_the_output_of_scene_show(self):
        for path in (ANCHOR, GRIPPER, DISCS):
            scene = phalanx.Scene.load(path)
            self.assertEqual(scene.toml, command("scene", "show", path))
            self.assertEqual(scene.resolved, command("scene", "show", path, "--resolved"))
        self.assertEqual([phalanx.Scene.load(path).kind for path in (ANCHOR, GRIPPER, DISCS)], ["finger", "gripper", "bodies"])

    def test_every_shipped_scene_survives_a_dictionary_round_trip(self):
        paths = [path for path in SCENES.glob("**/*.toml") if "studies" not in path.parts]
        self.assertGreater(len(paths), 40)
        for path in paths:
            with self.subTest(path=path.relative_to(ROOT)):
                scene = phalanx.Scene.load(path)
                restored = phalanx.Scene.from_dict(scene.to_dict())
                self.assertEqual(restored.resolved, scene.resolved)

    def test_shipped_scenes_are_valid_by_the_schema(self):
        schema = json.loads(command("schema", "scene"))
        jsonschema.Draft7Validator.check_schema(schema)
        validator = jsonschema.Draft7Validator(schema)
        paths = [path for path in SCENES.glob("**/*.toml") if "studies" not in path.parts]
        extending = 0
        for path in paths:
            document = tomllib.loads(path.read_text())
            extending += "extends" in document
            with self.subTest(path=path.relative_to(ROOT)):
                self.assertEqual([error.message for error in validator.iter_errors(document)], [])
        self.assertGreater(len(paths), 100)
        self.assertGreater(extending, 20)
        linkage = tomllib.loads((SCENES / "mechanisms" / "slider-crank.toml").read_text())

        def with_value(*path, value):
            changed = table = copy.deepcopy(linkage)
            for key in path[:-1]:
                table = table.setdefault(key, {})
            table[path[-1]] = value
            return validator.is_valid(changed)

        for value in ("= crank", " = 2 * crank", "30 mm"):
            self.assertTrue(with_value("bodies", "crank", "mass", value=value), value)
            self.assertTrue(with_value("bodies", "crank", "com", value=[value, "0 mm"]), value)
        self.assertTrue(with_value("integrator", "max_steps", value="= 2 * 1000"))
        self.assertTrue(with_value("parameters", "crank", value="= 2 * 15 mm"))
        self.assertTrue(with_value("parameters", "ratio", value=0.5))
        self.assertTrue(with_value("joints", "pin", "points[0][0]", value="30 mm"))
        self.assertFalse(with_value("parameters", "ratio", value=True))
        self.assertFalse(with_value("integrator", "max_steps", value="1000"))
        self.assertFalse(with_value("bodies", "crank", "mass", value="crank"))
        self.assertFalse(with_value("bodies", "crank", "mas", value="30 g"))

    def test_with_sets_fields_like_the_command_line(self):
        scene = phalanx.Scene.load(ANCHOR)
        changed = scene.with_({"contact.friction.mu_static": 0.6, "design.base": "14 mm", "palm": False})
        flags = ["--set", "contact.friction.mu_static=0.6", "--set", "design.base=14 mm", "--set", "palm=false"]
        self.assertEqual(changed.toml, command("scene", "show", ANCHOR, *flags))
        self.assertEqual(scene["design.base"], "15.5 mm")
        self.assertEqual(changed["design.base"], "14 mm")
        self.assertEqual(changed["design"]["arm_ratio"], 0.5)
        self.assertEqual(changed.with_({"design.base": "16 mm"})["design.base"], "16 mm")
        gravity = scene.with_({"gravity": ["0 m/s^2", "-1 m/s^2"], "contact.friction.mu_static": np.float64(0.5)})
        self.assertEqual(gravity["contact.friction.mu_static"], 0.5)
        with self.assertRaises(KeyError):
            scene["design.bsae"]

    def test_parameters_and_entries_of_lists_are_fields(self):
        text = (SCENES / "mechanisms" / "slider-crank.toml").read_text().replace('[["30 mm"', '[["= crank"')
        text = text.replace('kind = "mechanism"', 'kind = "mechanism"\nparameters = { crank = "30 mm", half = "= crank / 2" }')
        scene = phalanx.Scene.from_toml(text)
        self.assertEqual((scene["parameters.crank"], scene["parameters"]["half"]), ("30 mm", "= crank / 2"))
        self.assertEqual(scene["joints.pin.points[0][0]"], "= crank")
        changed = scene.with_({"parameters.crank": "31 mm", "joints.wrist.points[0][0]": "= 200 * half / 31", "gravity[1]": "-1 m/s^2"})
        self.assertEqual((changed["joints.wrist.points[0]"], changed["gravity[1]"]), (["= 200 * half / 31", "0 mm"], "-1 m/s^2"))
        by_values = phalanx.Scene.from_toml(text.replace('"= crank"', '"31 mm"'))
        by_values = by_values.with_({"joints.wrist.points[0][0]": f"{200 * (0.031 / 2) / 31!r} m", "gravity": ["0 m/s^2", "-1 m/s^2"]})
        self.assertEqual(changed.resolved, by_values.resolved)
        self.assertEqual(phalanx.Scene.from_dict(changed.to_dict()).resolved, changed.resolved)
        gradient = phalanx.run(scene, gradient=["parameters.crank", "joints.pin.points[0][0]"], duration="30 ms").gradient
        ends = [gradient[field]["end"]["values"]["crank_rad"] for field in ("parameters.crank", "joints.pin.points[0][0]")]
        self.assertEqual((gradient["parameters.crank"]["value"], gradient["parameters.crank"]["unit"]), (0.03, "m"))
        self.assertNotEqual(ends[0], 0.0)
        self.assertAlmostEqual(ends[0] / ends[1], 1, delta=1e-9)
        for field, message in (
            ("parameters.crnk", "unknown parameter `crnk`"),
            ("joints.pin.points[2]", "`joints.pin.points` has 2 entries, numbered from 0"),
            ("a b", "`a b` is not a field: write its sections and its key"),
        ):
            with self.subTest(field=field), self.assertRaisesRegex(phalanx.SceneError, message):
                scene.with_({field: "1 mm"})
        for field in ("joints.pin.points[2]", "a b", "parameters.crnk"):
            with self.subTest(field=field), self.assertRaises(KeyError):
                scene[field]

    def test_text_extends_a_scene_in_the_directory_of_its_name(self):
        text = 'extends = "experiment-95.toml"\nduration = "5 ms"\n'
        scene = phalanx.Scene.from_toml(text, str(SCENES / "mine.toml"))
        self.assertEqual((scene.duration_s, scene["design.base"]), (0.005, "15.5 mm"))

    def test_scene_error_has_a_position(self):
        with self.assertRaises(phalanx.SceneError) as caught:
            phalanx.Scene.from_toml('[design]\nbase = "12 s"\nbsae = 1\n', "own.toml")
        error = caught.exception
        self.assertEqual((error.file, error.line, error.column, error.field), ("own.toml", 2, 8, "design.base"))
        self.assertGreater(len(error.problems), 1)
        self.assertIn("own.toml:2:8", str(error))
        self.assertTrue(error.help)
        self.assertIsInstance(error, phalanx.PhalanxError)
        restored = pickle.loads(pickle.dumps(error))
        self.assertEqual((str(restored), restored.line, restored.problems), (str(error), 2, error.problems))

    def test_messages_equal_those_of_the_command_line(self):
        scene = phalanx.Scene.load(ANCHOR)
        for field, value in {"contact.friction.mu_static": -1, "design.base": "12", "design.bsae": "1 mm", "palm": "no"}.items():
            expected = command("run", ANCHOR, "--set", f"{field}={value}", status=2)
            with self.assertRaises(phalanx.SceneError) as caught:
                scene.with_({field: value})
            # Only the name of the source differs, and with its length the indentation.
            message = str(caught.exception).replace("with_:", "--set:")
            self.assertEqual(message.split(), expected.split())
            self.assertEqual(caught.exception.field, field)
        with self.assertRaises(phalanx.SceneError) as caught:
            phalanx.Scene.load("no-such.toml")
        self.assertEqual(str(caught.exception).strip(), command("run", "no-such.toml", status=2).strip())
        for invalid in ({"a b": 1}, {"design.base": ""}):
            with self.assertRaises(phalanx.SceneError):
                scene.with_(invalid)
        with self.assertRaises(TypeError):
            scene.with_({"design.base": object()})

    def test_scenes_can_be_pickled_and_copied(self):
        scene = phalanx.Scene.load(GRIPPER).with_({"contact.friction.mu_static": 0.3})
        for restored in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
            self.assertEqual(restored.resolved, scene.resolved)
        self.assertIn("0.3", repr(scene))


if __name__ == "__main__":
    unittest.main()
