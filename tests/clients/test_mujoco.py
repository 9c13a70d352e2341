"""MuJoCo reads the models of all shipped scenes, and of random grippers and mechanisms."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import logs

TOOLS = logs.PROJECT / "tools"
sys.path.insert(0, str(TOOLS))
import random_grippers  # noqa: E402

SEEDS = range(60)


class Models(unittest.TestCase):
    def test_are_read(self):
        with tempfile.TemporaryDirectory() as directory:
            scenes = [scene for scene in sorted(logs.SCENES.rglob("*.toml")) if scene.parent.name != "studies"]
            for seed in SEEDS:
                scene = Path(directory) / f"random{seed}.toml"
                scene.write_text(random_grippers.scene_text(random_grippers.random_scene(seed)[1]))
                scenes.append(scene)
            for index, scene in enumerate(scenes):
                try:
                    logs.phalanx("scene", "export", scene, "--mjcf", Path(directory) / f"{index}-{scene.stem}.xml")
                except RuntimeError as error:
                    # A refusal names its reason.
                    self.assertIn("prismatic joint", str(error))
            loaded = [sys.executable, TOOLS / "mujoco_load.py", directory]
            result = subprocess.run(loaded, capture_output=True, text=True, check=False)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


if __name__ == "__main__":
    unittest.main()
