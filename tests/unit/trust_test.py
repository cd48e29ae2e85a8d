"""The statistics of tests/bench/trust.py."""
import contextlib
import io
import math
import pathlib
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "bench"))
import trust  # noqa: E402


class Trust(unittest.TestCase):
    def test_the_six_coefficients_are_those_of_shrout_and_fleiss_1979(self):
        icc = trust.shrout_fleiss([[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7]])
        published = {"1,1": 0.17, "2,1": 0.29, "3,1": 0.71, "1,k": 0.44, "2,k": 0.62, "3,k": 0.91}
        self.assertEqual({name: round(icc[name], 2) for name in published}, published)

    def test_reliability_of_a_mean_agrees_with_spearman_and_brown(self):
        self.assertEqual([trust.trials_for(icc) for icc in (0.8, 0.5, 0.25, 0)], [1, 4, 12, math.inf])
        # Large samples of a known ICC: the interval of Bonett's sample size is as wide as requested.
        random = np.random.default_rng(1)
        n = trust.persons_for(0.6, 3)
        some = [trust.shrout_fleiss(math.sqrt(0.6) * random.normal(size=(n, 1)) + math.sqrt(0.4) * random.normal(
            size=(n, 3)))["1,1"] for _ in range(4000)]
        low, high = np.percentile(some, [2.5, 97.5])
        self.assertAlmostEqual(high - low, 0.2, delta=0.02)

    def test_agreement_counts_accepted_and_refused_trials(self):
        points = np.array([90, 80, 76, 60, 77, 50, 40, 30])
        acceptable = [1, 1, 1, 1, 0, 0, 0, 0]
        self.assertEqual(trust.agreement(points >= 75, acceptable), (0.75, 0.75))
        self.assertEqual(trust.best_mark(points, acceptable), (60, 0.75))
        self.assertAlmostEqual(trust.hedges_g([2, 4, 6], [1, 3, 5]), 0.5 * (1 - 3 / 15))

    def test_a_table_of_rescore_with_raters_gives_the_figures_of_its_people(self):
        lines = ["session,date,trainee,scene,truncated,points,full,completion,passed,error,rater_1,rater_2"]
        for person in range(6):
            for seed in (1, 2):
                for attempt in (0, 1):  # the second attempt at a case does not count
                    points = 50 + 9 * person + seed + 20 * attempt
                    lines.append(f"s.h5,2026-01-0{seed} 10:0{attempt},p{person},class-1-{seed},false,{points},100,1,"
                                 f"{'true' if points >= 75 else 'false'},,{points - 3},{points + 3}")
        lines.append("t.h5,2026-01-05 10:00,p9,class-1-1,false,,,,,cannot be read,,")
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "scores.csv"
            file.write_text("\n".join(lines))
            rows = trust.read(file)
            with contextlib.redirect_stdout(io.StringIO()) as out:
                trust.analyse(file)
            file.write_text("person,exercise,trial,points\na,class-1,1,many\n")
            with self.assertRaisesRegex(SystemExit, "row 2.*many"):
                trust.read(file)
        self.assertEqual(len(rows), 12)
        self.assertEqual([row["exercise"] for row in rows], ["class-1"] * 12)
        np.testing.assert_allclose(trust.matrix(rows), [[51 + 9 * p, 52 + 9 * p] for p in range(6)])
        self.assertIn("class-1 | 6 of 12 | 1.00", out.getvalue())

    def test_the_planned_error_is_the_worst_of_floor_and_walls(self):
        row = dict.fromkeys(trust.HAND, 0)
        self.assertAlmostEqual(trust.worst({**row, "z_mm": -0.5}), 2)
        self.assertAlmostEqual(trust.worst({**row, "x_mm": 0.15, "z_mm": 0.05}), 0.5)
        self.assertAlmostEqual(trust.worst({**row, "spread_mm": 0.05, "y_mm": 0.5}), 2)
        self.assertGreater(trust.worst({**row, "tilt_x_deg": 10}), 0.5)


if __name__ == "__main__":
    unittest.main()
