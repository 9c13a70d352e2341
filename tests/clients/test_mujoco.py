"""MuJoCo reads the models of all shipped scenes, and of random grippers and mechanisms."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import logs

TOOLS = logs.PROJECT / "tools"
CAMPAIGN = os.environ.get("PHALANX_CAMPAIGN", str(logs.PROJECT / "target/debug/examples/campaign"))
FAMILIES = ["objects", "jaws", "tendons", "linkages", "sliders", "thrown"]
SCENES_PER_FAMILY = 10


class Models(unittest.TestCase):
    def test_are_read(self):
        with tempfile.TemporaryDirectory() as directory:
            scenes = [scene for scene in sorted(logs.SCENES.rglob("*.toml")) if scene.parent.name != "studies"]
            chosen = ["--family", ",".join(FAMILIES), "--scenes", str(SCENES_PER_FAMILY)]
            subprocess.run([CAMPAIGN, *chosen, "--print", "--save", directory], check=True)
            random_scenes = sorted(Path(directory).glob("*.toml"))
            self.assertEqual(len(random_scenes), len(FAMILIES) * SCENES_PER_FAMILY)
            scenes += random_scenes
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
