"""Recomputes the output of `run --json` from the decoded messages of the log."""

import math
import unittest

import logs

TERMS = ["kinetic_j", "gravity_j", "spring_j", "elastic_j", "dissipated_j"]


class Figures(unittest.TestCase):
    def test_final_state_is_the_last_message(self):
        for run in logs.fingers():
            with self.subTest(run.name):
                last = run.log.states()[-1]
                self.assertEqual(last.timestamp, run.json["end_s"])
                for key, value in run.json["final"].items():
                    self.assertEqual(getattr(last, key), value, key)

    def test_contact_times(self):
        for run in logs.fingers() + logs.discs():
            for name, contact in run.json["contacts"].items():
                with self.subTest(run.name, contact=name):
                    touchdowns = run.log.touchdowns(name)
                    self.assertEqual(len(touchdowns), contact["touchdowns"])
                    self.assertEqual(touchdowns[0] if touchdowns else None, contact["first_s"])

    def test_contacts_that_never_close_have_no_channel(self):
        swing = logs.run("free-swing.toml")
        self.assertNotIn("/contact/proximal", swing.log.channels)

    def test_contact_forces_and_impulses(self):
        for run in logs.fingers() + logs.discs():
            for name, contact in run.json["contacts"].items():
                if name == "limit" or f"/contact/{name}" not in run.log.channels:
                    continue
                with self.subTest(run.name, contact=name):
                    samples = run.log.on(f"/contact/{name}")
                    self.assertEqual(samples[-1].normal_n, contact["final_normal_n"])
                    self.assertEqual(samples[-1].tangential_n, contact["final_tangential_n"])
                    self.assertEqual(samples[-1].impulse_n_s, contact["impulse_n_s"])
                    self.assertLessEqual(max(sample.normal_n for sample in samples), contact["peak_normal_n"])

    def test_limit(self):
        for run in logs.closings():
            with self.subTest(run.name):
                samples, reported = run.log.on("/contact/limit"), run.json["contacts"]["limit"]
                self.assertEqual(samples[-1].torque_n_m, reported["final_torque_n_m"])
                self.assertEqual(samples[-1].impulse_n_m_s, reported["impulse_n_m_s"])
                self.assertLessEqual(max(sample.torque_n_m for sample in samples), reported["peak_torque_n_m"])

    def test_energy(self):
        for run in logs.fingers() + logs.discs():
            with self.subTest(run.name):
                samples = run.log.on("/energy")
                for key, value in run.json["energy"].items():
                    self.assertEqual(getattr(samples[-1], key), value, key)
                start = math.fsum(getattr(samples[0], term) for term in TERMS)
                scale = max(abs(getattr(sample, term)) for sample in samples for term in TERMS)
                for sample in samples:
                    balance = math.fsum(
                        [*(getattr(sample, term) for term in TERMS), -sample.motor_work_j, -start]
                    )
                    # The sums differ only in the order of their terms.
                    self.assertAlmostEqual(balance, sample.balance_j, delta=1e-15 + 8 * 2.3e-16 * scale)

    def test_counts_of_replay(self):
        for run in logs.fingers() + logs.discs():
            with self.subTest(run.name):
                reported = logs.json.loads(logs.phalanx("replay", run.path, "--json"))
                self.assertTrue(reported["whole"])
                self.assertEqual(reported["messages"], len(run.log.messages))
                self.assertEqual(reported["samples"], len(run.log.on("/energy")))
                self.assertEqual(reported["events"], len(run.log.on("/event")))


class Penetration(unittest.TestCase):
    def test_deepest(self):
        for run in logs.closings() + logs.discs():
            for name, contact in run.json["contacts"].items():
                with self.subTest(run.name, contact=name):
                    if name == "limit":
                        gaps, reported = [s.gap_rad for s in run.log.on("/contact/limit")], contact["max_penetration_rad"]
                    else:
                        gaps, reported = [s.gap_m for s in run.log.on(f"/contact/{name}")], contact["max_penetration_m"]
                    self.assertEqual(max(0.0, -min(gaps)), reported)


if __name__ == "__main__":
    unittest.main()
