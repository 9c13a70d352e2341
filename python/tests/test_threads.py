"""Runs let other threads go on, and end at Ctrl-C."""

import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np
import phalanx
from common import ANCHOR, GRIPPER, ROOT

LONG = """
import phalanx, sys, time
scene = phalanx.Scene.load("scenes/experiment-95.toml").with_({"duration": "30 s"})
print("ready", flush=True)
try:
    %s
except KeyboardInterrupt:
    print("interrupted", flush=True)
else:
    print("done", flush=True)
"""


class Threads(unittest.TestCase):
    def test_other_threads_go_on_meanwhile(self):
        counted, over = [], threading.Event()

        def count() -> None:
            while not over.is_set():
                counted.append(time.monotonic())
                time.sleep(0.002)

        thread = threading.Thread(target=count)
        thread.start()
        start = time.monotonic()
        phalanx.run(GRIPPER, model="engine", duration="8 ms")
        end = time.monotonic()
        over.set()
        thread.join()
        during = [at for at in counted if start < at < end]
        # Of a lock that is held all the while there would be none, but at most one at either end.
        self.assertGreater(len(during), max(3, 0.05 * (end - start) / 0.002))

    def test_runs_on_many_threads_are_the_same(self):
        scene, found = phalanx.Scene.load(ANCHOR), {}

        def work(index: int) -> None:
            found[index] = [phalanx.run(scene)["q11_rad"] for _ in range(3)]

        threads = [threading.Thread(target=work, args=(index,)) for index in range(4)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        first = found[0][0]
        self.assertEqual(len(found), 4)
        for results in found.values():
            for other in results:
                np.testing.assert_array_equal(other, first)

    def interrupted(self, call: str) -> float:
        """How long it takes to end once Ctrl-C has been pressed, in s."""
        child = subprocess.Popen([sys.executable, "-c", LONG % call], cwd=ROOT, stdout=subprocess.PIPE, text=True)
        try:
            self.assertEqual(child.stdout.readline(), "ready\n")
            time.sleep(0.7)
            self.assertIsNone(child.poll())
            start = time.monotonic()
            child.send_signal(signal.SIGINT)
            self.assertEqual(child.stdout.readline(), "interrupted\n")
            return time.monotonic() - start
        finally:
            child.kill()
            child.wait()
            child.stdout.close()

    def test_ctrl_c_ends_whatever_runs(self):
        for call in (
            'phalanx.run(scene, model="engine", step="0.1 us")',
            'phalanx.evaluate(scene.with_({"duration": "1 s"}), {"design.base": [0.0155] * 64}, model="engine")',
            'phalanx.sweep("scenes/studies/capture.toml")',
            'phalanx.hold("scenes/gripper/hold.toml", scan=1000)',
            'phalanx.capture("scenes/gripper/offset.toml", places=1001)',
        ):
            with self.subTest(call=call):
                # A fraction of a second; more where others want the processors too. By themselves these take minutes.
                self.assertLess(self.interrupted(call), 3.0)


if __name__ == "__main__":
    unittest.main()
