"""Other threads continue during a run, and Ctrl-C interrupts it."""

import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np
import phalanx
from common import ANCHOR, GRIPPER, ROOT

INTERRUPTED_SCRIPT = """
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
    def test_other_threads_continue_during_a_run(self):
        ticks, run_ended = [], threading.Event()

        def tick() -> None:
            while not run_ended.is_set():
                ticks.append(time.monotonic())
                time.sleep(0.002)

        thread = threading.Thread(target=tick)
        thread.start()
        start = time.monotonic()
        phalanx.run(GRIPPER, model="engine", duration="8 ms")
        end = time.monotonic()
        run_ended.set()
        thread.join()
        during = [time_s for time_s in ticks if start < time_s < end]
        # If the run did not release the interpreter lock, there would be at most one tick at each end.
        self.assertGreater(len(during), max(3, 0.05 * (end - start) / 0.002))

    def test_parallel_runs_are_identical(self):
        scene, results_by_thread = phalanx.Scene.load(ANCHOR), {}

        def work(index: int) -> None:
            results_by_thread[index] = [phalanx.run(scene)["q11_rad"] for _ in range(3)]

        threads = [threading.Thread(target=work, args=(index,)) for index in range(4)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        first = results_by_thread[0][0]
        self.assertEqual(len(results_by_thread), 4)
        for results in results_by_thread.values():
            for other in results:
                np.testing.assert_array_equal(other, first)

    def interrupt_delay_s(self, call: str) -> float:
        """Returns the time between Ctrl-C and the end of a call, s."""
        child = subprocess.Popen([sys.executable, "-c", INTERRUPTED_SCRIPT % call], cwd=ROOT, stdout=subprocess.PIPE, text=True)
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

    def test_ctrl_c_interrupts_all_long_functions(self):
        for call in (
            'phalanx.run(scene, model="engine", step="0.1 us")',
            'phalanx.evaluate(scene.with_({"duration": "1 s"}), {"design.base": [0.0155] * 64}, model="engine")',
            'phalanx.sweep("scenes/studies/capture.toml")',
            'phalanx.hold("scenes/gripper/hold.toml", scan=1000)',
            'phalanx.capture("scenes/gripper/offset.toml", places=1001)',
        ):
            with self.subTest(call=call):
                # Usually a fraction of a second, more on a busy machine. Without an interrupt each call takes minutes.
                self.assertLess(self.interrupt_delay_s(call), 3.0)


if __name__ == "__main__":
    unittest.main()
