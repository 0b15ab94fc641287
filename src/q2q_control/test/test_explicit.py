"""The explicit law is the same in numpy, compiled and in C, and does what its teacher does."""

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_control.disturbance_tracker import TrackerParams
from q2q_control.explicit.c_export import c_source
from q2q_control.explicit.controller import ExplicitController
from q2q_control.explicit.distillation import Teacher, answers, distil, random_questions
from q2q_control.explicit.features import WHEN, WIDTH, features
from q2q_control.explicit.law import ExplicitLaw, evaluate, evaluate_one, from_text, packed, to_text
from q2q_control.mpc.params import MpcParams
from q2q_control.pid import PidParams
from q2q_model.interaction.jet import PAPER_LAW
from q2q_model.interaction.model import at_rest
from q2q_model.interaction.none import NoInteraction
from q2q_model.signals import Interference, SwarmSetpoint, SwarmState
from q2q_model.vehicle import GRAVITY, TEXTBOOK_065

TEACHER = Teacher(MpcParams(), TEXTBOOK_065, PAPER_LAW, 6.6)


def random_law(seed: int = 0) -> ExplicitLaw:
    rng = np.random.default_rng(seed)
    return ExplicitLaw(
        mean=rng.normal(size=WIDTH),
        scale=rng.uniform(0.5, 2.0, WIDTH),
        linear=rng.normal(size=WIDTH + 1) * 0.1,
        first=rng.normal(size=(12, WIDTH + 1)) * 0.3,
        second=rng.normal(size=(8, 13)) * 0.3,
        last=rng.normal(size=9) * 0.3,
        bounds=np.array([-1.0, 0.5]),
    )


def test_compiled_and_plain_evaluation_agree():
    law, x = random_law(), np.random.default_rng(1).normal(size=(50, WIDTH))
    weights, sizes = packed(law)
    singly = [evaluate_one(weights, sizes, row, np.empty(int(sizes.sum()))) for row in x]
    assert np.allclose(singly, evaluate(law, x), atol=1e-12)
    assert (np.abs(np.array(singly)) < 0.5).any()  # not all cut


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler: install one to check the export")
def test_the_c_export_compiles_without_warnings_and_agrees(tmp_path: Path):
    law, x = random_law(2), np.random.default_rng(3).normal(size=(20, WIDTH))
    numbers = ", ".join(f"{value:.9e}f" for value in np.float32(x).ravel())
    main = (
        "#include <stdio.h>\n"
        f"int main(void) {{ static const float all[20][{WIDTH}] = {{{numbers}}};\n"
        '  for (int k = 0; k < 20; ++k) printf("%.9e\\n", (double)q2q_explicit(all[k]));\n'
        f'  float bad[{WIDTH}] = {{0.0f}}; bad[0] = NAN; printf("%.9e\\n", (double)q2q_explicit(bad));\n'
        "  return 0; }\n"
    )
    source, program = tmp_path / "law.c", tmp_path / "law"
    source.write_text(c_source(law) + main, encoding="utf-8")
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-Wno-missing-braces"]
    subprocess.run(["cc", *flags, str(source), "-o", str(program), "-lm"], check=True)
    printed = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
    *values, of_nan = np.array(printed.split(), dtype=float)
    # single precision over sums of some 40 terms of order 1
    assert np.allclose(values, evaluate(law, x), atol=1e-5)
    assert of_nan == law.bounds[0]


def test_the_written_law_reads_back():
    law = random_law(4)
    again = from_text(to_text(law))
    x = np.random.default_rng(5).normal(size=(5, WIDTH))
    assert np.allclose(evaluate(again, x), evaluate(law, x), atol=1e-7)  # nine digits are written


@pytest.mark.parametrize("text", ["", "{}", '{"format": 2}', "[1]", '{"format": 1, "mean": [1]}'])
def test_what_is_no_law_is_refused(text: str):
    with pytest.raises(ValueError, match="explicit law"):
        from_text(text)


def test_a_law_cut_in_half_is_refused():
    text = to_text(random_law())
    with pytest.raises(ValueError, match="no explicit law"):
        from_text(text[: len(text) // 2])


def test_features_are_errors_gap_and_the_drafts_of_both_references():
    questions = random_questions(7, np.random.default_rng(6))
    x = features(questions.errors, questions.positions(WHEN), PAPER_LAW)
    assert x.shape == (7, WIDTH)
    assert np.array_equal(x[:, :4], questions.errors)
    references = questions.positions(WHEN)
    rel = (references[:, 1] - references[:, 0])[:, 4:8]  # the third window: 0.20 to 0.35 s
    assert np.allclose(x[:, 4], (questions.start[:, 1] - questions.start[:, 0])[:, 2])
    drafts = [PAPER_LAW.acceleration(sign * rel, at_rest(rel))[..., 2].mean(axis=1) for sign in (1, -1)]
    assert np.allclose(x[:, 5 + 2], drafts[0])
    assert np.allclose(x[:, 5 + 10 + 2], drafts[1])


def test_without_draft_the_teacher_is_linear_and_so_is_the_law():
    calm = replace(TEACHER, model=NoInteraction(), thrust_max=12.0)
    questions = random_questions(120, np.random.default_rng(7))
    said = answers(questions, calm)
    law = distil(questions, said, calm, (2, 2))
    fresh = random_questions(40, np.random.default_rng(8))
    found = evaluate(law, features(fresh.errors, fresh.positions(WHEN), NoInteraction()))
    assert np.abs(found - answers(fresh, calm)).max() < 1e-3 * np.abs(said).max()  # L-BFGS ends early


def test_a_distilled_law_answers_unseen_questions_better_than_its_linear_part():
    questions, fresh = (random_questions(count, np.random.default_rng(9 + count)) for count in (400, 100))
    said = answers(questions, TEACHER)
    law = distil(questions, said, TEACHER, (10, 6))
    truth = answers(fresh, TEACHER)
    x = features(fresh.errors, fresh.positions(WHEN), PAPER_LAW)
    straight = replace(law, last=np.zeros_like(law.last))
    assert np.std(evaluate(law, x) - truth) < 0.35 * np.std(truth)
    assert np.std(evaluate(law, x) - truth) < np.std(evaluate(straight, x) - truth)


def test_a_vehicle_alone_hovers_and_a_broken_state_is_survived():
    law = replace(random_law(), linear=np.zeros(WIDTH + 1), last=np.zeros(9))
    flown = ExplicitController(law, (PidParams(), TrackerParams()), TEXTBOOK_065, PAPER_LAW)
    zero, flag = np.zeros((1, 3)), np.zeros(1, np.uint8)
    level = np.array([[0.0, 0.0, 0.0, 1.0]])
    state = SwarmState(0.0, ("cf1",), zero, zero, level, zero, np.zeros(1), flag)
    setpoint = SwarmSetpoint(0.0, ("cf1",), zero, zero, zero, np.zeros(1), np.zeros(1), flag)
    draft = Interference(0.0, ("cf1",), zero, zero, flag)
    assert flown.update(state, setpoint, draft).thrust[0] == pytest.approx(0.65 * GRAVITY)
    broken = replace(state, t=0.01, pos=np.full((1, 3), np.nan))
    command = flown.update(broken, replace(setpoint, t=0.01), replace(draft, t=0.01))
    assert np.isfinite(command.thrust).all()
