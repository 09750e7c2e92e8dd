"""Faults of programs, put into statements of Fortran and Python by rules, and marks that tell which statements are reached."""
from __future__ import annotations

import ast
import keyword
import re
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

# A word stands for the other one of its pair: sides, parts of wheels and rails, axes, extremes.
PAIRS = ("left right, Left Right, LF RF, LT RT, L R, tread flange, y z, Y Z, vY vZ, Fy Fz, wheel rail, first last, min max, "
         "minval maxval, minloc maxloc, argmin argmax, minimum maximum, any all, sin cos, floor ceiling, True False, "
         ".true. .false.")
OTHER = {one: other for pair in PAIRS.split(", ") for one, other in (pair.split(), pair.split()[::-1])}
TURNED = {one: other for pair in ("< >", "<= >=", "== !=", "== /=", "in not in", "is is not", "and or", "+ -", ".and. .or.")
          for one, other in (pair.split(" ", 1), pair.split(" ", 1)[::-1])} | {"==": "!="}
# Where the order of two elements is nothing, and arguments of calls that no result shows.
UNORDERED = set("max min isclose isinstance hasattr range in startswith endswith dict tuple list Callable".split())
IDLE = set("strict stacklevel frozen slots repr kw_only maxsize check".split())
NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?(?:_\w+)?"
SIGNS = r"\*\*=?|//=?|=>|->|::|[<>=/!:+\-*|&%]=|[^\s\w]|\n"
TOKENS = {suffix: re.compile(rf"{strings}|{NUMBER}|\w+|{SIGNS}".encode()) for suffix, strings in {
    ".f90": r"""'(?:[^']|'')*'|"[^"]*"|![^\n]*|& *(?:![^\n]*)?\n *&?|\.[a-z]+\.""",
    ".py": r"""[rbf]{0,2}(?:"{3}(?:[^\\]|\\[\s\S])*?"{3}|"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')"""
           r"""|\#[^\n]*|\\\n|not\s+in\b|is\s+not\b""",
}.items()}
CALLS = set("call return exit cycle write read allocate deallocate open close inquire".split())
RESERVED = {*keyword.kwlist, *CALLS, "then", "do", "end"}
# First or last words of statements of Python that have no faults.
OUTSIDE = set("def class import from @ async global nonlocal assert else try finally except pass TYPE_CHECKING".split())
EXECUTED = {"simple", "if", "elseif", "while", "do"}


class Change(NamedTuple):
    """What is put for the bytes from start to end of a source."""

    start: int
    end: int
    new: str
    rule: str

    def of(self, source: bytes) -> bytes:
        return source[:self.start] + self.new.encode() + source[self.end:]


class Statement(NamedTuple):
    """Whole lines of a source, and the words of their code with their places."""

    kind: str                   # simple, if, elseif, while, do, parameter, or another one without faults
    words: list[str]
    places: list[tuple[int, int]]
    start: int
    end: int

    def close(self, k: int, way: int = 1) -> int:
        """The place of the parenthesis that belongs to that at place k."""
        depth = 0
        for n in range(k, len(self.words) if way > 0 else -1, way):
            depth += (self.words[n] in "([{") - (self.words[n] in ")]}")
            if not depth:
                return n
        return k

    def split(self, signs: str, first: int = 0) -> list[int]:
        """The places of one of the signs that stand in no parentheses."""
        found, k = [], first
        while k < len(self.words):
            if self.words[k] in signs.split():
                found.append(k)
            k = self.close(k) + 1
        return found


def statements(source: bytes, suffix: str) -> list[Statement]:
    """The statements of a source. Where no branch may stand, in `where` and below directives, they are of another kind."""
    found, words, places, start, depth, where, directed = [], [], [], 0, 0, False, False
    for token in TOKENS[suffix].finditer(source.rstrip() + b"\n"):
        word = token[0].decode()
        if word == "\n" and not depth:
            if words:
                one = Statement("other", words, places, start, token.end())
                kind = fortran_kind(one) if suffix == ".f90" else python_kind(words)
                where = kind == "where" or (where and words[:2] != ["end", "where"])
                found.append(one._replace(kind="other" if where or directed else kind))
                directed = False
            words, places, start = [], [], token.end()
        elif word.startswith(("!$omp atomic", "!$omp parallel")):
            directed = True
        elif word[0] not in "\n\\" and word[0] not in ("!&" if suffix == ".f90" else "#"):
            words.append(word)
            places.append(token.span())
            depth += ((word in "([{") - (word in ")]}"))*(suffix == ".py")
    return found


def python_kind(words: list[str]) -> str:
    texts = all(word[-1] in "'\"" for word in words)       # of documentation
    return "other" if texts or OUTSIDE & {words[-1], *words[:2]} else "simple"


def fortran_kind(one: Statement) -> str:
    words = one.words[2:] if one.words[1:2] == [":"] else one.words
    if {"function", "subroutine", ";"} & set(words):
        return "other"
    if "::" in words:
        return "parameter" if "parameter" in words[:words.index("::")] else "declaration"
    if words[0] == "where" and one.close(1) == len(words) - 1:
        return "where"
    if words[0] == "if":
        return "if" if words[-1] == "then" else "simple"
    if words[:2] == ["else", "if"]:
        return "elseif"
    if words[0] == "do":
        return "while" if "while" in words else "do" if "=" in words else "other"
    assigned = bool(one.split("=") or one.split("=>")) and words[0] not in ("use", "type") and words[1] in ("=", "=>", "%", "(")
    return "simple" if words[0] in CALLS or assigned else "other"


def blocks(tree: ast.Module) -> list[list[ast.stmt]]:
    """The sequences of statements inside functions of which each begins if the first does, but not those of classes and modules."""
    return [body for node in ast.walk(tree) if not isinstance(node, ast.Module | ast.ClassDef | ast.With)
            for body in (getattr(node, name, None) for name in ("body", "orelse", "finalbody"))
            if isinstance(body, list) and isinstance(body[0] if body else None, ast.stmt)]


def marks(source: bytes, suffix: str, found: list[Statement]) -> list[int | None]:
    """For each statement a number that tells whether it is reached; None outside of functions."""
    if suffix == ".py":
        ranges = [(body[-1].end_lineno - body[0].lineno, body[0].lineno, body[-1].end_lineno, k)
                  for k, body in enumerate(blocks(ast.parse(source)))]
        lines = [source[:one.places[0][0]].count(b"\n") + 1 for one in found]
        return [min((one for one in ranges if one[1] <= line <= one[2]), default=(0, 0, 0, None))[3] for line in lines]
    # Loops without branches are as fast as ever: what is inside is reached with them.
    inside, loops = dict[int, int](), list[int]()
    for n, one in enumerate(found):
        if one.words[:2] == ["end", "do"]:
            first = loops.pop()
            inside |= dict.fromkeys(range(first + 1, n), first) if first >= 0 else {}
        elif "do" in one.words[:3] and one.kind != "simple":
            loops.append(n if one.kind in EXECUTED else -1)
        elif one.kind in ("if", "elseif") or one.words[0] in ("if", "select", "exit", "cycle"):
            loops = [-1]*len(loops)
    lead, above = list[int | None](), list[int | None]()
    for n, one in enumerate(found):
        straight = n and found[n - 1].kind == "simple" and found[n - 1].words[0] != "if"
        lead.append(None if one.kind not in EXECUTED else lead[inside[n]] if n in inside else above[-1] if one.kind == "elseif" else
                    lead[-1] if straight else n)
        if one.kind == "if":
            above.append(lead[-1])
        elif one.words[:2] == ["end", "if"]:
            above.pop()
    return lead


def other_word(word: str) -> str:
    """The word with its first part that has a counterpart exchanged, `load_left` for `load_right`; nothing without one."""
    parts = [word] if word in OTHER else re.split(r"(_|\W+)", word)
    known = [k for k, part in enumerate(parts) if part in OTHER]
    return "".join(OTHER[part] if k == known[0] else part for k, part in enumerate(parts)) if known else ""


def other_number(word: str) -> list[str]:
    """An integer more and less by one; another number a tenth larger."""
    number, _, kind = word.partition("_")
    if number.isdecimal() and not kind:
        return [str(int(number) + 1), *([str(int(number) - 1)] if int(number) else [])]
    value = 1.1*float(re.sub("[dD]", "e", number))
    new = f"{value:.6g}" if value else "1.0"
    return [new + ".0"*new.isdecimal() + f"_{kind}"*bool(kind)]


def faults(source: bytes, one: Statement, suffix: str) -> Iterator[Change]:
    """The faults that the rules give a statement."""
    words, places, python = one.words, one.places, suffix == ".py"
    colons, equals = one.split(":"), one.split("= += -= *= /= |= &=" if python else "=")
    noted = python and colons and words[0] not in RESERVED and not (equals and equals[0] < colons[0])     # with a type
    begin = words.index("::") + 1 if one.kind == "parameter" else (equals or [len(words)])[0] if noted else 0
    value = equals[0] + 1 if equals else begin
    nearby = source[max(one.start - 1500, 0):one.end + 1500].decode(errors="ignore")
    known, dot = set(re.findall(r"\w+", nearby)), "." if python else "%"

    def operand(k: int) -> bool:
        return 0 <= k < len(words) and bool(re.search(r"[\w'\"\])}]$", words[k])) and words[k] not in RESERVED

    def beside(k: int, way: int, chain: bool = False) -> int:
        """The last word of the operand beside word k: a name with its parts and arguments, a number, parentheses; or a product."""
        n = k + way
        while 0 <= n < len(words):
            n = one.close(n, way) if words[n] in (")]}" if way < 0 else "([{") else n
            after = words[n + way] if 0 <= n + way < len(words) else ""
            if after == dot or (chain and after in ("*", "/", "**")):
                n += 2*way
            elif (after in ("(", "[") and operand(n)) if way > 0 else (words[n] in ("(", "[") and operand(n - 1)):
                n += way
            else:
                return n
        return k

    def text(a: int, b: int) -> str:
        return source[places[a][0]:places[b][1]].decode()

    for k in range(begin, len(words) if one.kind in EXECUTED | {"parameter"} else 0):
        word, (start, stop), before, after = words[k], places[k], words[k - 1] if k else "", (words + [""])[k + 1]
        if before == "=" and words[k - 2] in IDLE:
            continue
        if re.fullmatch(NUMBER, word):
            yield from (Change(start, stop, new, "constant") for new in other_number(word))
        if one.kind == "parameter":
            continue
        if word in ("not", ".not."):
            yield Change(start, stop, "", "condition")
        elif word in ("+", "-", "*", "/") and not operand(k - 1):
            yield from [Change(start, stop, "", "sign")] if word == "-" else []
        elif word in ("+", "-", "*", "/") and not any(part[-1:] in ("'", '"') for part in (before, after)):
            left, right = beside(k, -1, word in "+-"), beside(k, 1, word in "+-")
            ends, (one_side, two_side) = (places[left][0], places[right][1]), (text(left, k - 1), text(k + 1, right))
            yield from [Change(start, stop, TURNED[word], "sign")] if word in "+-" else []
            yield from [Change(*ends, f"{two_side} {word} {one_side}", "operands")] if word in "-/" and one_side != two_side else []
            yield from (Change(*ends, side, "term") for side in (one_side, two_side)[:1 if word in "-/" else 2])
        elif word in TURNED and not (word == "in" and "for" in words[:k]):
            new = "/=" if word == "==" and not python else TURNED[word]
            yield Change(start, stop, new, "and, or" if word.strip(".") in ("and", "or") else "comparison")
        elif (new := other_word(word)) and after != "=" and (word[-1] in "'\"." or new in known or (len(new) > 2 and new in OTHER)):
            yield Change(start, stop, new, "side")
        if python and word in ("if", "elif", "while") and after != "not":
            yield Change(places[k + 1][0], places[k + 1][0], "not ", "condition")
        if word == "," and operand(k - 1) and (right := beside(k, 1, True)) > k:
            left = beside(k, -1, True)
            opener, closer = (["", "", *words])[left:left + 2], (words + [")"])[right + 1]
            ends_there = closer in (",", ")", "]", "in", "for") or right + 1 in equals[:1]
            one_side, two_side = text(left, k - 1), text(k + 1, right)
            if (opener[1] in ("", "(", "[", ",", "=", "for", "return") and opener[0] not in UNORDERED and ends_there
                    and one_side != two_side):
                yield Change(places[left][0], places[right][1], f"{two_side}, {one_side}", "operands")
        if k >= value and operand(k) and re.match("[a-zA-Z'\"]", word) and after not in ("(", "=", ":="):
            part_of, quoted = before == dot, re.fullmatch(r"(['\"])\w+\1", word)
            head = rf"[{dot}]" if part_of else r"[\"'](?=\w+[\"'])" if quoted else r"(?<![\w.%'\"])"
            where = nearby if part_of else text(value, len(words) - 1)
            names = [name for name in re.findall(head + r"([a-zA-Z]\w*)(?!\w*\s*[(=.%])", where)
                     if name not in RESERVED]
            bare = word.strip("'\"")
            others = [name for name in names[names.index(bare):] + names if name != bare] if bare in names else []
            yield from [Change(start, stop, word.replace(bare, others[0]), "name")] if others else []
        if word[:2] in ("f'", 'f"'):
            yield from text_faults(word, start)
    if not python and (one.kind in ("if", "elseif", "while") or (one.kind == "simple" and words[0] == "if")):
        k = words.index("(")
        yield Change(places[k][1], places[one.close(k)][0], f".not. ({text(k + 1, one.close(k) - 1)})", "condition")
    stored = words[equals[0]] != "=" or words[equals[0] - 1] == "]" or "." in words[:equals[0]] if equals else words[-1] == ")"
    if one.kind == "simple" and not noted and (
            words[0] in ("raise", "continue", "break") or (stored and words[0] not in RESERVED) if python else
            words[0] in ("if", "call", "cycle", "exit") or words.count(words[0]) > 1):
        yield Change(places[0][0], places[-1][1], "pass" if python else "continue", "statement")


def text_faults(word: str, start: int) -> Iterator[Change]:
    """Faults of the values in a text of Python: two are exchanged, a number is changed."""
    def place(k: int) -> int:
        return start + len(word[:k].encode())

    found = list(re.finditer(r"(?<!\{)\{([^{}!:'\"]+)", word))
    for one, other in pairwise(found):
        if one[1] != other[1]:
            new = other[1] + word[one.end(1):other.start(1)] + one[1]
            yield Change(place(one.start(1)), place(other.end(1)), new, "operands")
    for one in found:
        for number in re.compile(rf"(?<!\w){NUMBER}").finditer(word, one.start(1), one.end(1)):
            yield from (Change(place(number.start()), place(number.end()), new, "constant") for new in other_number(number[0]))


def replaced(text: str, new: dict[str, str]) -> str:
    """Fortran with expressions for names of constants."""
    if new:
        one, = statements(text.encode(), ".f90") or [None]
        for k in reversed(range(len(one.words) if one else 0)):
            if one.words[k].lower() in new and one.words[k - 1:k] != ["%"] and one.words[k + 1:k + 2] not in (["="], ["("]):
                text = Change(*one.places[k], new[one.words[k].lower()], "").of(text.encode()).decode()
    return text


def part(one: Statement, change: Change) -> tuple[int, int] | None:
    """Where the condition or the bound of a loop is that has the change; None where it is elsewhere."""
    k = one.words.index("=" if one.kind == "do" else "(")
    places = [*one.places, (one.places[-1][1], 0)]
    bounds = [k, *one.split(",", k + 1), len(one.words)] if one.kind == "do" else [k, one.close(k)]
    ends = [(places[k][1], places[n][0]) for k, n in pairwise(bounds)]
    return next(((start, end) for start, end in ends if start <= change.start and change.end <= end), None)


def constant(one: Statement, source: bytes, change: Change) -> tuple[str, str] | None:
    """The name of the declared Fortran number that has the change, and the changed expression; None for arrays and texts."""
    k = max((k for k in one.split("=") if one.places[k][0] < change.start), default=0)
    end = min((n for n in one.split(",", k) if n > k), default=len(one.words)) - 1
    kind = "".join(one.words[:one.words.index(",")])
    if kind not in ("real(dp)", "integer") or "[" in one.words[k:end] or not re.match("[a-z]", one.words[k - 1]):
        return None
    start, stop = one.places[k + 1][0], one.places[end][1]
    new = Change(change.start - start, change.end - start, change.new, "").of(source[start:stop]).decode()
    return one.words[k - 1].lower(), f"real({new}, dp)" if kind == "real(dp)" else f"({new})"


def switched(source: bytes, changes: dict[int, Change], first_mark: int | None = None) -> bytes:
    """A Fortran source that has change k where the variable fault_number is k; with a first mark it notes what is reached."""
    found, out, constants = statements(source, ".f90"), [], dict[str, str]()
    lead, end = marks(source, ".f90", found), 0
    for one in found:
        for k, change in changes.items() if one.kind == "parameter" else ():
            if one.start <= change.start < one.end:
                name, new = constant(one, source, change)
                constants[name] = f"merge({new}, {constants.get(name, name)}, fault_number == {k})"
    for n, one in enumerate(found):
        mine = {k: change for k, change in changes.items() if one.start <= change.start < one.end and one.kind in EXECUTED}

        def piece(start: int, end: int, change: Change | None = None) -> str:
            text = source[start:end]
            changed = Change(change.start - start, change.end - start, change.new, "").of(text) if change else text
            return replaced(changed.decode(), constants)

        mark = f"call fault_mark({first_mark + n})\n" if first_mark is not None and lead[n] == n else ""
        out += [source[end:one.start].decode(), mark]
        end = one.end
        if one.kind not in EXECUTED:
            out.append(source[one.start:end].decode())
        elif one.kind == "simple":
            branches = [f"if (fault_number == {k}) then\n{piece(one.start, end, change)}else " for k, change in mine.items()]
            out += [*branches, "\n"*bool(mine), piece(one.start, end), "end if\n"*bool(mine)]
        else:
            begin, whole = one.start, source[one.start:end]
            for start, stop in sorted({part(one, change) for change in mine.values()}):
                text = whole[start - one.start:stop - one.start].decode()
                for k, change in mine.items():
                    if part(one, change) == (start, stop):
                        new = Change(change.start - start, change.end - start, change.new, "").of(source[start:stop]).decode()
                        text = (f"merge({new}, {text}, fault_number == {k})" if one.kind == "do" else
                                f"((fault_number == {k} .and. ({new})) .or. (fault_number /= {k} .and. ({text})))")
                out += [source[begin:start].decode(), text]
                begin = stop
            out.append(source[begin:end].decode())
    return re.sub(r"(?m)^((?:module|program) +\w+.*\n)", r"\1  use ldbench_fault\n", "".join(out), count=1).encode()
