"""Texts that are meant to break a reader of equations: right texts with pieces put in, cut out, repeated and nested."""

import random
from pathlib import Path

PIECES = [
    "__import__('os').system('touch pwned')",
    "exec(open('/etc/passwd').read())",
    r"\input{/etc/passwd}",
    r"\write18{touch pwned}",
    r"\def\x{\x\x}\x",
    "{{7*7}}",
    "${jndi:x}",
    "<script>alert(1)</script>",
    "9" * 400,
    "1e999999",
    "2^{2^{2^{2^{9}}}}",
    "x**999999999",
    "(" * 300,
    "{" * 300,
    r"\frac{" * 80,
    r"\left(" * 60,
    r"\begin{bmatrix}" * 5,
    r"\sqrt" * 60,
    "'" * 200,
    r"\dot" * 40 + r"\theta",
    r"\ddot{\ddot{\ddot{\theta}}}",
    "=" * 50,
    "= = =",
    "$$",
    r"\]\[",
    "\x00\x07\x1b[31m",
    "\u202e\u200b\ufeff",
    "∑∫∮√∞",
    "\U0001f600",
    "0/0",
    r"\frac{1}{0}",
    r"\frac{d^9\theta}{dt^9}",
    r"\frac{\partial}{\partial}",
    "a = b, b = c, c = a",
    r"$D = D + 1$ $D(\phi) = D(D(\phi))$",
    "theta = phi = m = l = g = 0",
    "T = T",
    "0 = 0",
    "1 = 2",
    r"\begin{align}",
    r"\end{align}",
    "| | | |",
    "# " * 100,
    "where $x$ is " + "the " * 200,
    "let $\\theta$ be the angle phi and $\\phi$ be the angle theta",
]


def hostile_text(seed: int, texts: list[str]) -> str:
    """A right text, damaged."""
    chance = random.Random(seed)
    text = chance.choice(texts)
    for _ in range(chance.randint(1, 4)):
        i, j = sorted(chance.randrange(len(text) + 1) for _ in range(2))
        piece = chance.choice(
            [*PIECES, text[i : i + 40], "".join(chance.choices("\\{}()[]=+-*/^_$'|&,.;dt09xθ", k=30))]
        )
        match chance.randrange(4):
            case 0:
                text = text[:i] + piece + text[i:]
            case 1:
                text = text[:i] + text[min(j, i + 60) :]
            case 2:
                text = text[:i] + f" ${piece}$ " + text[i:]
            case _:
                text = text[:i] + piece * chance.randint(1, 5) + text[min(j, i + 20) :]
    return text or PIECES[0]


def written_by_hand() -> list[str]:
    """The right texts of benchmarks/printed/texts.txt."""
    whole = (Path(__file__).parents[1] / "benchmarks" / "printed" / "texts.txt").read_text()
    return [part.partition("\n")[2] for part in whole.split("=== ")[1:]]
