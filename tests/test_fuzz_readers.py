"""The fuzzing of readers without the fuzzer: what it starts from is sound, and it sees what it is there to see."""

from pathlib import Path
from random import Random

import pytest

from fuzz_targets import reader, verdict
from mutations import mutate_text, mutate_zip

READERS = ("scene", "urdf", "npz", "csv")
MUTANTS = 30


@pytest.mark.parametrize("name", READERS)
def test_seeds_are_taken_and_what_is_made_of_them_is_taken_or_refused(name: str, tmp_path: Path) -> None:
    """Every seed is used to its end; some mutants, the same in every run, do no harm."""
    target, random = reader(name, tmp_path), Random(0)
    assert {verdict(target, tmp_path, seed) for seed in target.seeds} == {"taken"}
    found = []
    for _ in range(MUTANTS):
        seed = random.choice(target.seeds)
        if name == "npz":
            seed = mutate_zip(seed, target.words, random, lambda part: mutate_text(part, target.words, random))
        else:
            seed = mutate_text(seed, target.words, random)
        found.append(verdict(target, tmp_path, seed))
    assert {"taken", "refused"} == set(found)
