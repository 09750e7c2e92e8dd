"""Faults that programs can have, put into sources by rules, and the blocks of statements that a test may run."""
from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from itertools import accumulate, pairwise
from typing import NamedTuple

# A word of a pair stands for the other one: sides, parts of wheels and rails, axes, extremes.
PAIRS = [("left", "right"), ("Left", "Right"), ("LF", "RF"), ("LT", "RT"), ("L", "R"), ("tread", "flange"), ("y", "z"), ("Y", "Z"),
         ("vY", "vZ"), ("Fy", "Fz"), ("wheel", "rail"), ("first", "last"), ("min", "max"), ("minval", "maxval"),
         ("minloc", "maxloc"), ("argmin", "argmax"), ("minimum", "maximum"), ("any", "all"), ("sin", "cos"), ("floor", "ceiling")]
OTHER = {one: other for pair in PAIRS for one, other in (pair, pair[::-1])}
TURNED = {"<": ">", ">": "<", "<=": ">=", ">=": "<=", "==": "!=", "!=": "==", "in": "not in", "not in": "in", "is": "is not",
          "is not": "is", "and": "or", "or": "and", "+": "-", "-": "+", ".and.": ".or.", ".or.": ".and."}
SYMMETRIC = {"max", "min", "isclose", "isinstance", "issubclass", "getattr", "setattr", "hasattr", "range", "merge"}
IDLE = {"strict", "stacklevel", "frozen", "slots", "repr", "kw_only", "maxsize", "encoding", "check"}     # words of calls that no result shows


class Change(NamedTuple):
    """What is put for the bytes from start to end of a source."""

    start: int
    end: int
    new: str
    rule: str


def other_word(word: str) -> str:
    """The word with a part that has a counterpart exchanged, `load_left` for `load_right`; nothing where no part has one."""
    parts = re.split(r"(_|\W+)", word)
    known = [k for k, part in enumerate(parts) if part in OTHER]
    return "".join(OTHER[part] if k == known[0] else part for k, part in enumerate(parts)) if known else ""


def other_number(text: str) -> list[str]:
    """An integer less and more by one; another number a tenth larger."""
    if re.fullmatch(r"\d+", text):
        return [str(int(text) + 1), *([str(int(text) - 1)] if int(text) > 0 else [])]
    number, _, kind = text.partition("_")
    value = float(number.lower().replace("d", "e"))
    new = f"{1.1*value:.6g}" if value else "1.0"
    return [new + ".0"*new.isdecimal() + (f"_{kind}" if kind else "")]


def blocks(tree: ast.Module) -> list[tuple[ast.AST, list[ast.stmt]]]:
    """The sequences of statements in which all run if the first does, and the node from which each is entered."""
    return [(node, body) for node in ast.walk(tree) if not isinstance(node, ast.Module | ast.ClassDef | ast.With)
            for body in (getattr(node, name, None) for name in ("body", "orelse", "finalbody", "handlers"))
            if isinstance(body, list) and body and isinstance(body[0], ast.stmt)]


def starts_of_lines(source: bytes) -> list[int]:
    return [0, *accumulate(len(line) for line in source.splitlines(keepends=True))]


def block_at(tree: ast.Module, source: bytes, at: int) -> int | None:
    """Which of the blocks has the byte, the innermost; those of a function have its head, too."""
    lines, found = starts_of_lines(source), []
    for k, (node, body) in enumerate(blocks(tree)):
        first = node if isinstance(node, ast.FunctionDef) else body[0]
        start = lines[first.lineno - 1] + first.col_offset
        end = lines[body[-1].end_lineno - 1] + body[-1].end_col_offset
        if start <= at < end:
            found.append((end - start, k))
    return min(found)[1] if found else None


def python_faults(source: bytes) -> Iterator[Change]:
    """Faults of a Python source, outside of annotations, decorators, docstrings and calls that no result depends on."""
    tree, lines = ast.parse(source), starts_of_lines(source)
    words = set(re.findall(r"\w+", source.decode()))
    parents = {child: node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}

    def begin(node: ast.AST) -> int:
        return lines[node.lineno - 1] + node.col_offset

    def end(node: ast.AST) -> int:
        return lines[node.end_lineno - 1] + node.end_col_offset

    def text(start: int, stop: int) -> str:
        return source[start:stop].decode()

    def between(one: ast.AST, two: ast.AST, sign: str) -> int | None:
        found = re.search(rf"(?<![\w*/<>=!]){re.escape(sign)}(?![\w*/<>=])".replace(" ", r"\s+"), text(end(one), begin(two)))
        return end(one) + found.start() if found else None

    def left_out(node: ast.AST) -> bool:
        above = parents.get(node)
        return above is not None and (
            any(node is part or part == node for part in (getattr(above, "annotation", None), getattr(above, "returns", None)))
            or node in getattr(above, "decorator_list", ()) or (isinstance(above, ast.keyword) and above.arg in IDLE)
            or (isinstance(above, ast.Expr) and isinstance(node, ast.Constant)) or isinstance(node, ast.Import | ast.ImportFrom)
            or getattr(getattr(node, "test", None), "id", "") == "TYPE_CHECKING" or left_out(above))

    signs = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.And: "and", ast.Or: "or", ast.Lt: "<", ast.Gt: ">",
             ast.LtE: "<=", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=", ast.In: "in", ast.NotIn: "not in", ast.Is: "is",
             ast.IsNot: "is not"}
    for node in ast.walk(tree):
        if not hasattr(node, "lineno") or left_out(node):
            continue
        start, stop = begin(node), end(node)
        if isinstance(parents.get(node), ast.FormattedValue | ast.JoinedStr) and not isinstance(node, ast.Name):
            continue        # places inside texts with values are not exact before Python 3.12
        if isinstance(node, ast.BinOp) and type(node.op) in signs:
            sign = signs[type(node.op)]
            at = between(node.left, node.right, sign)
            if at is None or any(isinstance(side, ast.JoinedStr | ast.List | ast.Tuple) or isinstance(getattr(side, "value", 0), str)
                                 for side in (node.left, node.right)):
                continue
            one, two = text(start, at).rstrip(), text(at + 1, stop).lstrip()
            if sign in TURNED:
                yield Change(at, at + 1, TURNED[sign], "sign")
            if sign in "-/" and one != two:
                yield Change(start, stop, f"{two}{text(at, at + 1).join('  ') if sign == '-' else sign}{one}", "operands")
            yield Change(start, stop, one, "term")
            if sign in "+*":
                yield Change(start, stop, two, "term")
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            yield Change(start, start + 1, "", "sign")
        elif isinstance(node, ast.Compare | ast.BoolOp):
            first, second, sign = ((node.left, node.comparators[0], signs[type(node.ops[0])]) if isinstance(node, ast.Compare)
                                   else (*node.values[:2], signs[type(node.op)]))
            if (at := between(first, second, sign)) is not None:
                yield Change(at, at + len(sign), TURNED[sign], "comparison" if isinstance(node, ast.Compare) else "and, or")
        elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
            yield Change(start, stop, str(not node.value), "constant")
        elif isinstance(node, ast.Constant) and isinstance(node.value, int | float) and re.fullmatch(r"[\d.]+(e-?\d+)?", text(start, stop)):
            yield from (Change(start, stop, new, "constant") for new in other_number(text(start, stop)))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and (new := other_word(text(start, stop))):
            yield Change(start, stop, new, "side")
        elif isinstance(node, ast.Name | ast.Attribute):
            name = getattr(node, "id", getattr(node, "attr", ""))
            if isinstance(node.ctx, ast.Load) and text(stop - len(name), stop) == name and other_word(name) in words - {name}:
                yield Change(stop - len(name), stop, other_word(name), "side")
        elif isinstance(node, ast.Call) and len(node.args) > 1 and getattr(node.func, "id", "") not in SYMMETRIC:
            one, two = node.args[:2]
            if all(isinstance(side, ast.Name | ast.Attribute | ast.Subscript) for side in (one, two)) and ast.dump(one) != ast.dump(two):
                yield Change(begin(one), end(two), text(begin(two), end(two)) + text(end(one), begin(two)) + text(begin(one), end(one)),
                             "operands")
        elif (isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant)) or isinstance(node, ast.AugAssign | ast.Raise | ast.Continue | ast.Break) or (
                isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute | ast.Subscript)):
            yield Change(start, stop, "pass", "statement")
        for test in [getattr(node, "test", None), *getattr(node, "ifs", ())] if not isinstance(node, ast.Assert) else []:
            if test is not None:
                yield Change(begin(test), end(test), f"not ({text(begin(test), end(test))})", "condition")


class Statement(NamedTuple):
    """A statement of a Fortran source: its whole lines, and its code without comments and ends of lines, with the place of each token."""

    start: int
    end: int
    kind: str                               # simple, if, elseif, while, do, parameter, or another one
    tokens: list[tuple[str, int, int]]


TOKEN = re.compile(rb"""'(?:[^']|'')*'|"[^"]*"|![^\n]*|&[ ]*(?:!.*)?\n[ ]*&?|\.\w+\.|(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?(?:_\w+)?|\w+
                        |\*\*|//|[<>=/]=|=>|::|[^\s\w]|\n""", re.VERBOSE)
SIMPLE = {"call", "return", "exit", "cycle", "write", "read", "allocate", "deallocate", "open", "close", "inquire", "nullify"}
EXECUTED = {"simple", "if", "elseif", "while", "do"}
CLOSED = {"end", "endif", "enddo", "else", "elsewhere", "case", "class", "type", "contains", "module", "program", "subroutine", "function"}


def closing(tokens: list[tuple[str, int, int]], k: int) -> int:
    """The place of the parenthesis that closes the one at place k."""
    depth = 0
    for n in range(k, len(tokens)):
        depth += (tokens[n][0] in "([") - (tokens[n][0] in ")]")
        if not depth:
            return n
    return k


def statements(source: bytes) -> Iterator[Statement]:
    """The statements of a Fortran source, those of `where` constructs as another kind, for no branch may stand there."""
    tokens, start, where = [], 0, False
    for found in TOKEN.finditer(source.rstrip() + b"\n"):
        word = found[0].decode()
        if word != "\n":
            if word[0] not in "!&":
                tokens.append((word, found.start(), found.end()))
            continue
        if tokens:
            words = [token[0].lower() for token in tokens]
            kind, first = "other", words[2] if words[1:2] == [":"] else words[0]
            last = closing(tokens, 1) if words[1:2] == ["("] else 0
            if {"function", "subroutine"} & set(words):
                kind = "procedure"
            elif "::" in words:
                kind = "parameter" if "parameter" in words[:words.index("::")] else "declaration"
            elif ";" in words or where or words[0][0] == "#":
                where = where and words[:2] != ["end", "where"]
            elif first == "where" and last == len(words) - 1:
                where = True
            elif first == "if":
                kind = "if" if words[-1] == "then" else "simple"
            elif words[:2] == ["else", "if"]:
                kind = "elseif"
            elif first == "do":
                kind = "while" if "while" in words else "do" if "=" in words else "other"
            elif first in SIMPLE or (first not in CLOSED and ("=" in words or "=>" in words) and words[1] in ("=", "=>", "%", "(")
                                     and first not in ("select", "associate", "block", "use", "where")):
                kind = "simple"
            yield Statement(start, found.end(), kind, tokens)
        tokens, start = [], found.end()


def fortran_faults(source: bytes, one: Statement, known: set[str]) -> Iterator[Change]:
    """Faults of a statement of a source that has the known words."""
    if one.kind not in EXECUTED | {"parameter"}:
        return
    tokens = one.tokens
    words = [token[0] for token in tokens]
    first = words.index("::") + 1 if one.kind == "parameter" else 0

    def operand(k: int, way: int) -> int:
        """The last token of the operand that begins beside token k: a name with its parts and arguments, a number, or parentheses."""
        n, depth = k + way, 0
        while 0 <= n < len(words):
            depth += (words[n] in "([") - (words[n] in ")]")
            if depth*way < 0:
                break
            after = words[n + way] if 0 <= n + way < len(words) else ""
            joined = after == "%" or words[n] == "%" or (
                (after[:1] in ("(", "[") and re.match(r"\w", words[n])) if way > 0 else
                (words[n] in ("(", "[") and re.match(r"\w", after)))
            if not depth and not joined:
                return n
            n += way
        return n - way

    def text(a: int, b: int) -> str:
        return source[tokens[a][1]:tokens[b][2]].decode()

    for k, (word, start, stop) in enumerate(tokens):
        before, after = words[k - 1] if k else "", words[k + 1] if k + 1 < len(words) else ""
        if k < first or not after and one.kind == "if":
            continue
        if re.match(r"\d", word) and before not in ("_",):
            yield from (Change(start, stop, new, "constant") for new in other_number(word))
        elif word in (".true.", ".false."):
            yield Change(start, stop, ".false." if word == ".true." else ".true.", "constant")
        elif one.kind == "parameter":
            continue
        elif word == ".not.":
            yield Change(start, stop, "", "condition")
        elif word in ("+", "-") and after and (before in ("(", "=", ",", "[") or before.startswith(".")):
            if word == "-":
                yield Change(start, stop, "", "sign")
        elif word in ("+", "-", "*", "/") and before and after:
            left, right = operand(k, -1), operand(k, 1)
            one_side, two_side = text(left, k - 1), text(k + 1, right)
            if word in "+-":
                yield Change(start, stop, TURNED[word], "sign")
            if word in "-/" and one_side != two_side:
                yield Change(tokens[left][1], tokens[right][2], f"{two_side} {word} {one_side}", "operands")
            yield Change(tokens[left][1], tokens[right][2], one_side, "term")
            if word in "+*":
                yield Change(tokens[left][1], tokens[right][2], two_side, "term")
        elif word in ("<", ">", "<=", ">=", "==", "/=", ".and.", ".or."):
            new = {"==": "/=", "/=": "=="}.get(word) or TURNED[word]
            yield Change(start, stop, new, "and, or" if word[0] == "." else "comparison")
        elif (new := other_word(word)) and (word[0] in "'\"" or new in known or new in ("min", "max", "minval", "maxval", "any", "all")):
            yield Change(start, stop, new, "side")
        elif after == "(" and re.match(r"[a-z]", word) and word not in SYMMETRIC | {"if", "while"}:
            comma, last = operand(k + 1, 1) + 1, closing(tokens, k + 1)
            if words[comma:comma + 1] == [","] and (stop := operand(comma, 1)) + 1 <= last and words[stop + 1] in ",)":
                one_side, two_side = text(k + 2, comma - 1), text(comma + 1, stop)
                if one_side != two_side and "=" not in words[k:last] and ":" not in one_side + two_side:
                    yield Change(tokens[k + 2][1], tokens[stop][2], f"{two_side}, {one_side}", "operands")
    if "if" in words[:2] or one.kind == "while":
        k = words.index("(")
        yield Change(tokens[k][2], tokens[closing(tokens, k)][1], f".not. ({text(k + 1, closing(tokens, k) - 1)})", "condition")
    if one.kind == "simple" and (words[0] in ("if", "call", "cycle", "exit") or words.count(words[0]) > 1):
        yield Change(tokens[0][1], tokens[-1][2], "continue", "statement")


def leaders(found: list[Statement]) -> list[int]:
    """For each statement that one whose execution tells that it is reached."""
    lead, above = list(range(len(found))), []
    for n, one in enumerate(found):
        words = [token[0] for token in one.tokens[:2]]
        if one.kind == "elseif":
            lead[n] = above[-1]
        elif one.kind in EXECUTED and n and found[n - 1].kind == "simple" and found[n - 1].tokens[0][0] != "if":
            lead[n] = lead[n - 1]
        if one.kind == "if":
            above.append(lead[n])
        elif words in (["end", "if"], ["endif"]):
            above.pop()
    return lead


def replaced(text: str, new: dict[str, str]) -> str:
    """A statement with expressions for names of constants."""
    if not new:
        return text
    source, found = text.encode(), []
    tokens = [token for token in TOKEN.finditer(source) if token[0][:1] not in b"!&\n"]
    for k, token in enumerate(tokens):
        before, after = (tokens[n][0] if 0 <= n < len(tokens) else b"" for n in (k - 1, k + 1))
        if (name := token[0].decode().lower()) in new and before != b"%" and after not in (b"=", b"("):
            found.append((token.start(), token.end(), new[name]))
    for start, end, expression in reversed(found):
        source = source[:start] + expression.encode() + source[end:]
    return source.decode()


def part(one: Statement, change: Change) -> tuple[int, int] | None:
    """The condition or the bound of a loop that has the change; nothing where it is elsewhere."""
    tokens, depth, k = one.tokens, 0, [token[0] for token in one.tokens].index("=" if one.kind == "do" else "(")
    bounds = [k] if one.kind == "do" else [k, closing(tokens, k)]
    for n in range(k + 1, len(tokens)) if one.kind == "do" else ():
        depth += (tokens[n][0] == "(") - (tokens[n][0] == ")")
        if tokens[n][0] == "," and not depth:
            bounds.append(n)
    ends = [(tokens[k][2], tokens[n][1]) for k, n in pairwise(bounds)]
    if one.kind == "do":
        ends.append((tokens[bounds[-1]][2], tokens[-1][2]))
    return next(((start, end) for start, end in ends if start <= change.start and change.end <= end), None)


def switched(source: bytes, changes: dict[int, Change], constants: dict[str, str], first_mark: int | None = None) -> bytes:
    """A Fortran source that has fault k of `changes` where the variable fault_number is k, and expressions for names of constants;
    with a first mark it notes which statements were reached."""
    out, found = [], list(statements(source))
    lead = leaders(found)
    for n, one in enumerate(found):
        mine = {k: change for k, change in changes.items() if one.start <= change.start < one.end and one.kind in EXECUTED}

        def version(k: int, start: int, end: int) -> str:
            change = mine[k]
            return replaced((source[start:change.start] + change.new.encode() + source[change.end:end]).decode(), constants)

        def kept(start: int, end: int) -> str:
            return replaced(source[start:end].decode(), constants)

        if first_mark is not None and one.kind in EXECUTED - {"elseif"} and lead[n] == n:
            out.append(f"call fault_mark({first_mark + n})\n")
        if one.kind not in EXECUTED:
            out.append(source[one.start:one.end].decode())
        elif one.kind == "simple":
            branches = [f"if (fault_number == {k}) then\n{version(k, one.start, one.end)}else " for k in mine]
            out.append("".join(branches).removesuffix(" ") + "\n"*bool(mine) + kept(one.start, one.end) + "end if\n"*bool(mine))
        else:
            begin = one.start
            for start, end in sorted({part(one, change) for change in mine.values()}):
                expression = kept(start, end)
                for k in mine:
                    if part(one, mine[k]) == (start, end):
                        expression = (f"merge({version(k, start, end)}, {expression}, fault_number == {k})" if one.kind == "do" else
                                      f"((fault_number == {k} .and. ({version(k, start, end)})) .or. (fault_number /= {k} .and. ({expression})))")
                out += [kept(begin, start), expression]
                begin = end
            out.append(kept(begin, one.end))
    return re.sub(r"(?m)^((?:module|program) +\w+.*\n)", r"\1  use ldbench_fault\n", "".join(out), count=1).encode()


def constant(one: Statement, source: bytes, change: Change) -> tuple[str, str] | None:
    """The name of the declared number that has the change, and the expression with it; nothing for arrays and texts."""
    words = [token[0] for token in one.tokens]
    kind = "".join(words[:words.index(",")])
    name = max((k for k in range(len(words)) if words[k] == "=" and one.tokens[k][1] < change.start), default=0)
    depth, last = 0, name + 1
    while last < len(words) and (depth or words[last] != ","):
        depth += (words[last] in "([") - (words[last] in ")]")
        last += 1
    if kind not in ("real(dp)", "integer") or "[" in words[name:last] or not re.match(r"\w", words[name - 1]):
        return None
    start, end = one.tokens[name + 1][1], one.tokens[last - 1][2]
    new = (source[start:change.start] + change.new.encode() + source[change.end:end]).decode()
    return words[name - 1].lower(), f"real({new}, dp)" if kind == "real(dp)" else f"({new})"
