"""The pages, help, errors and public docstrings have none of the stiff patterns that docs/language.py finds."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

FILE = Path(__file__).parents[1] / "docs" / "language.py"


@pytest.fixture(scope="module")
def language() -> ModuleType:
    """The script, which is not part of the package."""
    spec = importlib.util.spec_from_file_location("language", FILE)
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_all_that_is_read_is_plain(language: ModuleType) -> None:
    """`python docs/language.py` prints the same list."""
    assert language.findings() == []


@pytest.mark.parametrize(
    ("sentence", "rule"),
    [
        ("Of so short a run most is output.", "Of ... in front"),
        ("'x' is no number of a rod", "is no N"),
        ("What is shorter may be missed.", "What ... as a noun"),
        ("The sweep goes on where it was.", "goes on"),
        ("Six times that estimate is taken.", "is taken"),
        ("A file is written whole.", "whole"),
        ("It was tried so many times.", "so many, so much"),
        ("A smaller swing ends so too.", "ends so"),
        ("It takes 0.05, 0.16, 0.7 and 2.4 us for each.", "numbers in a row"),
        ("Six methods are slow: they are explicit; radau is fast.", "colons and semicolons"),
        ("The ledger balances.", "words of builders"),
        (" ".join(["word"] * 50), "too long"),
    ],
)
def test_each_pattern_is_found(language: ModuleType, sentence: str, rule: str) -> None:
    """In a sentence of its kind."""
    assert rule in {name for name, _ in language.flags(sentence)}


@pytest.mark.parametrize(
    "sentence",
    [
        "What does it cost?",
        "There is no other file.",
        "It is no longer needed.",
        "solver.step: 0 is not above 0; a step is in s",
        "The times are 1, 2 and 3 s.",
        "Of course it holds.",
    ],
)
def test_plain_sentences_pass(language: ModuleType, sentence: str) -> None:
    """A false alarm would make writers avoid good English."""
    assert not list(language.flags(sentence))
