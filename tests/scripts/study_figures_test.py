"""Figures of a study for a paper: what stands in them, failures, hostile names, wrong words."""
import math
import unittest

from hand_made_study import StudyCase, printed

import study_figures
from study_folder import Study


class StudyFigures(StudyCase):
    def one(self, **more):
        runs = [(q, seed, m, (v * seed, 0.05 if m == "fixed_10" else 0.1)) for q, m, v in (
            ("a", "fixed_10", 0.1), ("a", "as_lio_plus", 0.05), ("b", "fixed_10", 0.2), ("b", "as_lio_plus", 0.3)) for seed in (1, 2, 3)]
        runs += [("a", 1, "it's <b>", (0.2, 0.2)), ("b", 1, "it's <b>", (None, None), "diverged")]
        self.study("mine", runs, figures=("ate_m", "cpu_s_per_s"), baselines=[("as_lio_plus", "fixed_10")], **more)
        return self.root

    def test_every_figure_is_drawn_in_both_formats(self):
        for form in ("svg", "pdf"):
            code, out, err = printed(study_figures.main, self.one(), "--output", self.root / "figures", "--format", form)
            self.assertEqual((code, err), (0, ""))
            for kind in ("errors", "ratios", "cost"):
                path = self.root / "figures" / f"mine_{kind}.{form}"
                self.assertIn(f"wrote {path}\n", out)
                self.assertGreater(path.stat().st_size, 1000)
        text = (self.root / "figures/mine_ratios.svg").read_text()
        for words in ("as_lio_plus", "it's &lt;b>", "0.50", "1.50", "1.00", ">x<"):
            self.assertIn(words, text, words)

    def test_medians_and_failures(self):
        figures = study_figures.Figures(Study(self.one()), "ate_m", None)
        self.assertEqual(figures.medians("as_lio_plus"), [0.1, 0.6])
        self.assertEqual(figures.medians("it's <b>"), [0.2, math.inf])
        script = figures.cost()
        self.assertIn("(1 failed)", script)  # hollow, and where the others are
        self.assertIn("pt 6", script)
        self.assertIn("'it''s <b> (1 failed)'", script)
        self.assertEqual(figures.errors().count(" 2\n"), 1)  # one run in the band of those that failed

    def test_wrong_words(self):
        for more, complaint in ((["--metric", "nonsense"], "has such a figure"), (["--metric", "rpe"], "has such a figure"),
                                (["--methods", "fixed_10,asl"], "the study has fixed_10, as_lio_plus")):
            code, _, err = printed(study_figures.main, self.one(), "--output", self.root / "figures", *more)
            self.assertEqual(code, 2)
            self.assertIn(complaint, err)
        code, _, err = printed(study_figures.main, self.root / "none", "--output", self.root / "figures")
        self.assertEqual(code, 2)
        self.assertIn("name an output folder", err)


if __name__ == "__main__":
    unittest.main()
