"""Faults that programs have, put into statements of Fortran and Python by rules, and marks that tell which statements are reached."""
from __future__ import annotations

import ast
import keyword
import re
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

# A word stands for the other one of its pair: sides, parts of wheels and rails, axes, extremes.
PAIRS = ("left right, Left Right, LF RF, LT RT, L R, tread flange, y z, Y Z, vY vZ, Fy Fz, wheel rail, first last, min max, minval maxval, "
         "minloc maxloc, argmin argmax, minimum maximum, any all, sin cos, floor ceiling, True False, .true. .false.")
OTHER = {one: other for pair in PAIRS.split(", ") for one, other in (pair.split(), pair.split()[::-1])}
TURNED = {one: other for pair in ("< >", "<= >=", "== !=", "== /=", "in not in", "is is not", "and or", "+ -", ".and. .or.")
          for one, other in (pair.split(" ", 1), pair.split(" ", 1)[::-1])} | {"==": "!="}
UNORDERED = {"max", "min", "isclose", "isinstance", "hasattr", "range", "in", "startswith", "endswith", "dict", "tuple", "list", "Callable"}
IDLE = {"strict", "stacklevel", "frozen", "slots", "repr", "kw_only", "maxsize", "check"}      # arguments of calls that no result shows
NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?(?:_\w+)?"
TOKENS = {suffix: re.compile(rf"{strings}|{NUMBER}|\w+|\*\*=?|//=?|=>|->|::|[<>=/!:+\-*|&%]=|[^\s\w]|\n".encode()) for suffix, strings in {
    ".f90": r"""'(?:[^']|'')*'|"[^"]*"|![^\n]*|& *(?:![^\n]*)?\n *&?|\.[a-z]+\.""",
    ".py": r'''[rbf]{0,2}(?:"{3}(?:[^\\]|\\[\s\S])*?"{3}|"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')|#[^\n]*|\\\n|not\s+in\b|is\s+not\b''',
}.items()}
CALLS = {"call", "return", "exit", "cycle", "write", "read", "allocate", "deallocate", "open", "close", "inquire"}
OUTSIDE = {"def", "class", "import", "from", "@", "async", "global", "nonlocal", "assert", "else", "try", "finally", "except", "pass",
           "TYPE_CHECKING"}
RESERVED = {*keyword.kwlist, *CALLS, "then", "do", "end"}
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
    """The statements of a source. Those in the construct `where` and below directives, where no branch may stand, are of another kind."""
    found, words, places, start, depth, where, directed = [], [], [], 0, 0, False, False
    for token in TOKENS[suffix].finditer(source.rstrip() + b"\n"):
        word = token[0].decode()
        if word == "\n" and not depth:
            if words:
                one = Statement("other", words, places, start, token.end())
                kind = fortran_kind(one) if suffix == ".f90" else "other" if OUTSIDE & {words[0], words[-1], *words[1:2]} or all(
                    part[-1] in "'\"" for part in words) else "simple"
                where = kind == "where" or (where and words[:2] != ["end", "where"])
                found.append(one._replace(kind="other" if where or directed else kind))
                directed = False
            words, places, start = [], [], token.end()
        elif word.startswith(("!$omp atomic", "!$omp parallel")):
            directed = True
        elif word[0] not in "\n\\" and not (word[0] in "!&" and suffix == ".f90") and not (word[0] == "#" and suffix == ".py"):
            words.append(word)
            places.append(token.span())
            depth += ((word in "([{") - (word in ")]}"))*(suffix == ".py")
    return found


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
        ranges = [(body[-1].end_lineno - body[0].lineno, body[0].lineno, body[-1].end_lineno, k)  # type: ignore[operator]
                  for k, body in enumerate(blocks(ast.parse(source)))]
        lines = [source[:one.places[0][0]].count(b"\n") + 1 for one in found]
        return [min((one for one in ranges if one[1] <= line <= one[2]), default=(0, 0, 0, None))[3] for line in lines]  # type: ignore
    lead: list[int | None] = []
    above: list[int | None] = []
    for n, one in enumerate(found):
        straight = n and found[n - 1].kind == "simple" and found[n - 1].words[0] != "if"
        lead.append(above[-1] if one.kind == "elseif" else None if one.kind not in EXECUTED else lead[-1] if straight else n)
        if one.kind == "if":
            above.append(lead[-1])
        elif one.words[:2] == ["end", "if"]:
            above.pop()
    return lead


def other_word(word: str) -> str:
    """The word with its first part that has a counterpart exchanged, `load_left` for `load_right`; nothing where no part has one."""
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
    noted = python and colons and words[0] not in keyword.kwlist and not (equals and equals[0] < colons[0])
    begin = words.index("::") + 1 if one.kind == "parameter" else (equals or [len(words)])[0] if noted else 0
    known = set(re.findall(r"\w+", source[max(one.start - 2000, 0):one.end + 2000].decode(errors="ignore")))

    def operand(k: int) -> bool:
        return 0 <= k < len(words) and bool(re.search(r"[\w'\"\])}]$", words[k])) and words[k] not in RESERVED

    def beside(k: int, way: int, chain: bool = False) -> int:
        """The last word of the operand beside word k: a name with its parts and arguments, a number, parentheses; or a product."""
        n = k + way
        while 0 <= n < len(words):
            n = one.close(n, way) if words[n] in (")]}" if way < 0 else "([{") else n
            after = words[n + way] if 0 <= n + way < len(words) else ""
            if after == ("." if python else "%") or (chain and after in ("*", "/", "**")):
                n += 2*way
            elif (after in ("(", "[") and operand(n)) if way > 0 else words[n] in ("(", "[") and operand(n - 1):
                n += way
            else:
                return n
        return k

    def text(a: int, b: int) -> str:
        return source[places[a][0]:places[b][1]].decode()

    for k in range(begin, len(words) if one.kind in EXECUTED | {"parameter"} else 0):
        word, (start, stop), before, after = words[k], places[k], words[k - 1] if k else "", words[k + 1] if k + 1 < len(words) else ""
        if before == "=" and words[k - 2] in IDLE:
            continue
        if re.fullmatch(NUMBER, word):
            yield from (Change(start, stop, new, "constant") for new in other_number(word))
        elif one.kind == "parameter":
            continue
        elif word in ("not", ".not."):
            yield Change(start, stop, "", "condition")
        elif word in ("+", "-", "*", "/") and not operand(k - 1):
            yield from [Change(start, stop, "", "sign")] if word == "-" else []
        elif word in ("+", "-", "*", "/") and not any(part[-1] in "'\"" for part in (before, after)):
            left, right = beside(k, -1, word in "+-"), beside(k, 1, word in "+-")
            ends, (one_side, two_side) = (places[left][0], places[right][1]), (text(left, k - 1), text(k + 1, right))
            yield from [Change(start, stop, TURNED[word], "sign")] if word in "+-" else []
            yield from [Change(*ends, f"{two_side} {word} {one_side}", "operands")] if word in "-/" and one_side != two_side else []
            yield from (Change(*ends, side, "term") for side in (one_side, two_side)[:1 if word in "-/" else 2])
        elif (new := TURNED.get(word, "")) and not (word == "in" and (words[0] == "for" or "for" in words[:k])):
            yield Change(start, stop, new if python or word != "==" else "/=", "and, or" if word.strip(".") in ("and", "or") else "comparison")
        elif (new := other_word(word)) and before not in ("def", "import") and after != "=" and (
                word[0] in "rbf.'\"" or new in known | OTHER.keys() and (new in known or len(new) > 2) and words[k - 1:k] != ["."]):
            yield Change(start, stop, new, "side")
        if python and word in ("if", "elif", "while") and after != "not":
            yield Change(places[k + 1][0], places[k + 1][0], "not ", "condition")
        if word == "," and operand(k - 1) and (right := beside(k, 1, True)) > k:
            left = beside(k, -1, True)
            opener, closer = ([""]*2 + words)[left:left + 2], words[right + 1] if right + 1 < len(words) else ")"
            one_side, two_side = text(left, k - 1), text(k + 1, right)
            if opener[1] in ("", "(", "[", ",", "=", "for", "return") and opener[0] not in UNORDERED and (closer in (",", ")", "]", "in", "for") or
                                                                right + 1 in equals[:1]) and one_side != two_side:
                yield Change(places[left][0], places[right][1], f"{two_side}, {one_side}", "operands")
        kind = rf"[{'.' if python else '%'}]" if before in (".", "%") else r"[\"'](?=\w+[\"'])" if re.fullmatch(r"(['\"])\w+\1", word) else r"(?<![\w.%'\"])"
        read = equals[0] + 1 if equals else begin
        if k >= read and operand(k) and re.match("[a-zA-Z'\"]", word) and after not in ("(", "=", ":="):
            near = source[max(one.start - 500, 0):one.end + 500].decode(errors="ignore") if before in (".", "%") else text(read, len(words) - 1)
            names = [name for name in re.findall(kind + r"([a-zA-Z]\w*)(?!\w*\s*[(=.%])", near) if name not in RESERVED]
            bare = word.strip("'\"")
            others = [name for name in names[names.index(bare):] + names if name != bare] if bare in names else []
            yield from [Change(start, stop, word.replace(bare, others[0]), "name")] if others else []
        if word[:2] in ("f'", 'f"'):
            parts = [(start + len(word[:found.start(1)].encode()), found[1]) for found in re.finditer(r"(?<!\{)\{([^{}!:'\"]+)", word)]
            for (at, part), (behind, other) in pairwise(parts):
                if part != other:
                    between = source[at + len(part.encode()):behind].decode()
                    yield Change(at, behind + len(other.encode()), f"{other}{between}{part}", "operands")
            for at, part in parts:
                for found in re.finditer(rf"(?<!\w){NUMBER}", part):
                    yield from (Change(at + len(part[:found.start()].encode()), at + len(part[:found.end()].encode()), new, "constant")
                                for new in other_number(found[0]))
    whole = places[0][0], places[-1][1]
    if not python and (one.kind in ("if", "elseif", "while") or (one.kind == "simple" and words[0] == "if")):
        k = words.index("(")
        yield Change(places[k][1], places[one.close(k)][0], f".not. ({text(k + 1, one.close(k) - 1)})", "condition")
    if python and one.kind == "simple" and not noted and (words[0] in ("raise", "continue", "break") or (words[0] not in keyword.kwlist and (
            words[equals[0]] != "=" or words[equals[0] - 1] == "]" or "." in words[:equals[0]] if equals else words[-1] == ")"))):
        yield Change(*whole, "pass", "statement")
    if not python and one.kind == "simple" and (words[0] in ("if", "call", "cycle", "exit") or words.count(words[0]) > 1):
        yield Change(*whole, "continue", "statement")


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
    bounds = [k, *one.split(",", k + 1), len(one.words)] if one.kind == "do" else [k, one.close(k)]
    ends = [(one.places[k][1], one.places[n][0] if n < len(one.words) else one.places[-1][1]) for k, n in pairwise(bounds)]
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
    """A Fortran source that has change k where the variable fault_number is k; with a first mark it notes the statements reached."""
    found, out, constants = statements(source, ".f90"), [], dict[str, str]()
    lead, end = marks(source, ".f90", found), 0
    for one in found:
        for k, change in changes.items() if one.kind == "parameter" else ():
            if one.start <= change.start < one.end:
                name, new = constant(one, source, change)  # type: ignore[misc]
                constants[name] = f"merge({new}, {constants.get(name, name)}, fault_number == {k})"
    for n, one in enumerate(found):
        mine = {k: change for k, change in changes.items() if one.start <= change.start < one.end and one.kind in EXECUTED}

        def piece(start: int, end: int, change: Change | None = None) -> str:
            text = source[start:end]
            return replaced((Change(change.start - start, change.end - start, change.new, "").of(text) if change else text).decode(), constants)

        out += [source[end:one.start].decode(), f"call fault_mark({first_mark + n})\n" if first_mark is not None and lead[n] == n else ""]
        end = one.end
        if one.kind not in EXECUTED:
            out.append(source[one.start:end].decode())
        elif one.kind == "simple":
            branches = [f"if (fault_number == {k}) then\n{piece(one.start, end, change)}else " for k, change in mine.items()]
            out += [*branches, "\n"*bool(mine), piece(one.start, end), "end if\n"*bool(mine)]
        else:
            begin, whole = one.start, source[one.start:end]
            for start, stop in sorted({part(one, change) for change in mine.values()}):  # type: ignore[type-var]
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
