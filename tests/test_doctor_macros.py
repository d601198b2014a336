"""Macros of LaTeX documents, written out where they are used."""

from pendpin.doctor.printed import name_states, parse_statements
from pendpin.doctor.reading.documents import read_text
from pendpin.doctor.reading.tree import key

MACROS = r"""\documentclass{article}
\newcommand{\dd}{\mathrm{d}}
\newcommand{\ang}[1]{\theta_{#1}}
\providecommand*{\rate}[1]{\dot{\ang{#1}}}
\def\both{m_1 + m_2}
\newcommand{\by}[2]{
  \frac{\partial #1}{\partial #2}}
\begin{document}
$$V = -(\both)g l_1\cos\ang1 - m_2 g l_2\cos\ang{2}$$
$$\by{L}{\rate1} =
(\both)l_1^2\rate1 + m_2 l_1 l_2\rate2\cos(\ang1-\ang2), \quad \frac{\dd}{\dd t}\ang
1 = \rate1$$
$$x_1 = l_1\sin\ang1$$
"""


def test_macros_are_written_out():
    """As the document without them, at the same lines."""
    plain = MACROS.partition(r"\begin{document}")[2].replace(r"\both", "m_1 + m_2").replace("\\ang\n1", "\\theta_1\n")
    plain = plain.replace(r"\by{L}{\rate1}", r"\frac{\partial L}{\partial\dot\theta_1}").replace(r"\dd", r"\mathrm{d}")
    for i in "12":
        for name, letter in (("ang", r"\theta"), ("rate", r"\dot\theta")):
            plain = plain.replace(rf"\{name}{i}", f"{letter}_{i}").replace(rf"\{name}{{{i}}}", f"{letter}_{i}")
    shown = lambda text: [[*map(key, one.sides)] for one in name_states(parse_statements(read_text(text).statements))]  # noqa: E731
    assert shown(MACROS) == shown(plain)
    places = [one.place for one in read_text(MACROS).statements]
    assert places == ["line 9", "line 10", "line 11", "line 13"]


def test_macros_of_themselves_end():
    """What grows without end is left as it is."""
    bomb = "".join(rf"\newcommand{{\{a}a}}{{\{b}a\{b}a\{b}a}}" for a, b in zip("abcdefgh", "bcdefghi", strict=True))
    for text in (
        bomb + r"$\aa = 1$",
        r"\newcommand{\xx}{\xx\xx}$\xx = 2$",
        r"\newcommand{\yy}{$a = b",
        r"\def\zz{}$\zz a = b$",
    ):
        assert len(read_text(text).text) < 10 * len(text)
