"""Trees as MathML, which browsers typeset without fonts or network; changed parts are marked."""

import html
from dataclasses import replace

from pendpin.doctor.reading.names import LETTERS, Written, of_word
from pendpin.doctor.reading.tree import Node, Span

SIGNS = {"*": "", "x": "×", ".": "·"}


def equation(sides: tuple[Node, ...], changed: tuple[Span, ...] = ()) -> str:
    """Sides that are equal, as a displayed formula of pieces, one a term, between which a narrow page breaks the line."""
    equal = "<mo>=</mo>"
    pieces = [piece for i, side in enumerate(sides) for piece in _pieces(side, changed, equal if i else "")]
    pieces += [f"{equal}<mn>0</mn>"] if len(sides) < 2 else []
    return f'<div class="equation">{" ".join(f"<math><mrow>{piece}</mrow></math>" for piece in pieces)}</div>'


def _pieces(side: Node, changed: tuple[Span, ...], before: str) -> list[str]:
    """A side term by term; whole where it is no sum, or all of it has changed."""
    whole = any(a <= side.span[0] and side.span[1] <= b for a, b in changed)
    first, *others = (
        _terms(side, changed) if side.kind == "sum" and not side.bracketed and not whole else [part(side, changed)]
    )
    return [before + first, *others]


def part(node: Node, changed: tuple[Span, ...]) -> str:
    """One node; marked where the characters that changed are its own or those of all that is in it."""
    text = _inside(node, changed)
    if node.bracketed and node.kind in ("sum", "product") and not node.fraction:
        text = f"<mrow><mo>(</mo>{text}<mo>)</mo></mrow>"
    return (
        f'<mrow class="changed">{text}</mrow>'
        if any(a <= node.span[0] and node.span[1] <= b for a, b in changed)
        else text
    )


def _inside(node: Node, changed: tuple[Span, ...]) -> str:
    values = node.value
    match node.kind:
        case "number":
            return (
                f"<mn>{values}</mn>"
                if values.denominator == 1
                else f"<mfrac><mn>{values.numerator}</mn><mn>{values.denominator}</mn></mfrac>"
            )
        case "symbol":
            return symbol(node.written or Written(str(values).lstrip("?")))
        case "sum":
            return _sum(node, changed)
        case "product":
            return _product(node, changed)
        case "power":
            return _power(node, changed)
        case "function":
            return _function(node, changed)
        case "matrix":
            rows, columns = values
            cells = [f"<mtd>{part(child, changed)}</mtd>" for child in node.children]
            lines = "".join(f"<mtr>{''.join(cells[i * columns : (i + 1) * columns])}</mtr>" for i in range(rows))
            return f"<mrow><mo>[</mo><mtable>{lines}</mtable><mo>]</mo></mrow>"
        case _:
            return _derivative(node, changed)


def _derivative(node: Node, changed: tuple[Span, ...]) -> str:
    """Dots over a symbol without a name for its rate; d over dt, or over what else, before anything else."""
    inner, order = node.children[0], 1
    while inner.kind == "derivative" and inner.value == node.value and not inner.bracketed:
        inner, order = inner.children[0], order + 1
    if node.value == "t" and inner.kind == "symbol":
        written = inner.written or Written(str(inner.value).lstrip("?"))
        return symbol(replace(written, dots=written.dots + order))
    name = str(node.value).lstrip("?")
    sign, variable = ("d", "<mi>t</mi>") if name == "t" else ("∂", symbol(of_word(name) or Written(name)))
    above, below = f"<mi>{sign}</mi>", variable
    if order > 1:
        above, below = (f"<msup>{text}<mn>{order}</mn></msup>" for text in (above, below))
    return f"<mrow><mfrac>{above}<mrow><mi>{sign}</mi>{below}</mrow></mfrac>{part(inner, changed)}</mrow>"


def _power(node: Node, changed: tuple[Span, ...]) -> str:
    """A base with its exponent, which of a function stands at its name."""
    exponent, child = _mark(f"<mn>{node.value}</mn>", node.marks[0], changed), node.children[0]
    if child.kind == "function" and child.value not in ("sqrt", "norm") and child.bracketed is None:
        return _function(child, changed, exponent)
    return f"<msup>{_base(child, changed)}{exponent}</msup>"


def _mark(text: str, span: Span, changed: tuple[Span, ...]) -> str:
    touched = any(a < span[1] and span[0] < b for a, b in changed)
    return f'<mrow class="changed">{text}</mrow>' if touched else text


def _sum(node: Node, changed: tuple[Span, ...]) -> str:
    return f"<mrow>{''.join(_terms(node, changed))}</mrow>"


def _terms(node: Node, changed: tuple[Span, ...]) -> list[str]:
    """The terms of a sum, each with its sign; the first only with a minus."""
    terms = []
    for i, (sign, child) in enumerate(zip(node.value, node.children, strict=True)):
        mark = _mark(f"<mo form='infix'>{'−' if sign < 0 else '+'}</mo>" if i else "<mo>−</mo>", node.marks[i], changed)
        terms.append((mark if sign < 0 or i else "") + part(child, changed))
    return terms


def _product(node: Node, changed: tuple[Span, ...]) -> str:
    """Factors side by side; what is divided by stands below a line."""
    text, operators = "", node.value
    for operator, child in zip(operators, node.children, strict=True):
        inner = part(child, changed)
        if node.fraction:
            inner = _bare(child, inner)
        if operator == "/":
            text = f"<mfrac><mrow>{text}</mrow><mrow>{_bare(child, inner)}</mrow></mfrac>"
        else:
            number = child.kind == "number" and text.endswith("</mn>")
            sign = "·" if number else SIGNS[operator] if operator != "*" else ""
            space = '<mspace width="0.17em"/>' if text and child.kind in ("function", "power") else ""
            text += (f"<mo>{sign}</mo>" if sign else space) + inner
    return f"<mrow>{text}</mrow>"


def _bare(child: Node, text: str) -> str:
    """Below a line no brackets are needed."""
    wrapped = child.bracketed and text.startswith("<mrow><mo>(</mo>") and text.endswith("<mo>)</mo></mrow>")
    return text[len("<mrow><mo>(</mo>") : -len("<mo>)</mo></mrow>")] if wrapped else text


def _base(child: Node, changed: tuple[Span, ...]) -> str:
    if child.kind == "function" and child.value not in ("sqrt", "norm"):
        return f"<mrow><mo>(</mo>{part(child, changed)}<mo>)</mo></mrow>"
    return f"<mrow>{part(child, changed)}</mrow>"


def _function(node: Node, changed: tuple[Span, ...], exponent: str = "") -> str:
    inner = part(node.children[0], changed)
    if node.value == "sqrt":
        return f"<msqrt>{inner}</msqrt>"
    if node.value == "transpose":
        return f"<msup>{inner}<mi>T</mi></msup>"
    if node.value == "norm":
        return f"<mrow><mo>|</mo>{inner}<mo>|</mo></mrow>"
    name = _mark(f"<mi>{node.value}</mi>", node.marks[0], changed)
    name = f"<msup>{name}{exponent}</msup>" if exponent else name
    if node.children[0].kind in ("symbol", "number"):
        return f"<mrow>{name}<mo>&#8289;</mo><mspace width='0.15em'/>{inner}</mrow>"
    return f"<mrow>{name}<mo>(</mo>{_bare(node.children[0], inner)}<mo>)</mo></mrow>"


def symbol(written: Written) -> str:
    """A name with its dots, hat and index."""
    letter = html.escape(LETTERS.get(written.letter, written.letter))
    text = f"<mi>{letter}</mi>"
    hat = written.letter in "xyzijkne" or (written.letter in "ab" and written.index in ("1", "2", "3"))
    if written.styled and hat:
        text = f'<mover accent="true">{text}<mo>^</mo></mover>'
    elif written.styled:
        text = f'<mi style="font-weight: bold">{letter}</mi>'
    if written.dots:
        text = f'<mover>{text}<mo stretchy="false">{"." * written.dots}</mo></mover>'
    if written.index:
        text = f"<msub>{text}<mi>{html.escape(written.index)}</mi></msub>"
    if len(written.frames) == 2:
        before, after = map(html.escape, written.frames)
        text = f"<mmultiscripts>{text}<none/><mi>{after}</mi><mprescripts/><none/><mi>{before}</mi></mmultiscripts>"
    return text
