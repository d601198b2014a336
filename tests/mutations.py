"""What the fuzzing of readers makes of good files: texts with a piece changed, zips with a member changed."""

import re
import warnings
import zipfile
from collections.abc import Callable
from io import BytesIO
from random import Random

NUMBERS = "0 -1 1 2 0.5 -0.0 nan inf 1e100 1e101 -1e150 1e308 1e400 5e-324 1e-160 1e-14 true 1_0 0x10 1,5 1999-01-01"


def unpacked(data: bytes) -> bytes:
    """The same zip without compression, so that its bytes mean something."""
    return packed(_members(data))


def packed(members: list[tuple[str, bytes]]) -> bytes:
    """A zip of members, in their order; names may repeat."""
    file = BytesIO()
    with zipfile.ZipFile(file, "w") as archive, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a name that repeats
        for name, data in members:
            archive.writestr(zipfile.ZipInfo(name), data)
    return file.getvalue()


def _members(data: bytes) -> list[tuple[str, bytes]]:
    with zipfile.ZipFile(BytesIO(data)) as archive:
        return [(info.filename, archive.read(info)) for info in archive.infolist()]


def mutate_text(data: bytes, words: list[str], random: Random) -> bytes:
    """Text with one number replaced, or one piece of it replaced by a word, left out, doubled, or moved."""
    pieces = re.findall(r"[\w.+-]+|\s+|.", data.decode(errors="surrogateescape")) or [""]
    numbers = [i for i, piece in enumerate(pieces) if re.search(r"\d", piece)]
    at, other = random.randrange(len(pieces)), random.randrange(len(pieces))
    length = min(len(pieces), 1 + int(random.expovariate(0.2)))
    match random.randrange(10):
        case 0:
            pieces[at : at + length] = []
        case 1:
            pieces[other:other] = pieces[at : at + length]
        case 2:
            pieces[at] = pieces[other]
        case 3 | 4:
            pieces[at] = random.choice(words)
        case _ if numbers:
            pieces[random.choice(numbers)] = random.choice([random.choice(NUMBERS.split()), _number(random)])
    return "".join(pieces).encode(errors="surrogateescape")


def _number(random: Random) -> str:
    """A number of any sign and size, most of them moderate."""
    return f"{random.choice([-1, 1, 1]) * 10 ** random.gauss(0, random.choice([1, 1, 30])):.3g}"


def mutate_zip(data: bytes, words: list[str], random: Random, mutate: Callable[[bytes], bytes]) -> bytes:
    """A zip with one member changed, left out, doubled or renamed, and its checksums right again."""
    try:
        members = _members(data)
        at = random.randrange(len(members))
    except Exception:  # not a zip any more
        return mutate(data)
    name, content = members[at]
    match random.randrange(12):
        case 0:
            del members[at]
        case 1:
            members.append((name, mutate(content)))
        case 2:
            members[at] = (mutate_text(name.encode(), words, random).decode(errors="replace"), content)
        case 3 | 4 | 5 if name == "meta.npy":
            members[at] = (name, _mutate_meta(content, words, random))
        case 3 | 4 | 5 | 6:
            members[at] = (name, mutate_text(content[:128], words, random) + content[128:])
        case 7:
            members[at] = (name, members[random.randrange(len(members))][1])
        case _:
            members[at] = (name, mutate(content))
    return packed(members)


def _mutate_meta(content: bytes, words: list[str], random: Random) -> bytes:
    """The array of one text with a piece of it changed, and a header that fits."""
    text = content[128:].decode("utf-32-le", errors="replace").encode(errors="replace")
    mutated = mutate_text(text, words, random).decode(errors="replace") or " "
    header = f"{{'descr': '<U{len(mutated)}', 'fortran_order': False, 'shape': (), }}"
    return b"\x93NUMPY\x01\x00\x76\x00" + header.ljust(117).encode() + b"\n" + mutated.encode("utf-32-le")
