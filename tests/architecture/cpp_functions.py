"""Functions of C++ sources: where they begin, how many lines and parameters they have.

The counter reads the layout that clang-format gives to the code, not the language: a brace at the level of a namespace or a class opens a function if
parentheses stand before it and it is not the initializer of a variable. Lambdas count as part of the function around them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

# Comments, preprocessor lines, strings and characters: their braces and commas do not count. ' inside of a number separates digits.
IGNORED = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:\\\n|[^\n])*', re.S | re.M)
SCOPE = re.compile(r"^(?:inline\s+)?namespace\b|^(?:class|struct|union|enum)\b[^()=]*$|^extern\b[^()=]*$", re.S)
NAME = re.compile(r"(operator\s*(?:[^\s\w(]+|\s[\w:]+)|~?[\w:~]+)\s*$")
ANGLE = re.compile(r"->|\boperator\s*[<>=-]+")
NOT_NAMES = {"requires", "noexcept", "alignas", "decltype", "__attribute__"}


@dataclass(frozen=True)
class Function:
    name: str
    line: int
    lines: int
    parameters: int


def without_ignored(source: str) -> str:
    """The same text, with the same lines, without what does not count."""
    def blank(match: re.Match[str]) -> str:
        text = match.group()
        value = "" if text.startswith("/") or text.lstrip().startswith("#") else "0"
        return value + re.sub(r"[^\n]", "", text)
    return IGNORED.sub(blank, source)


def closing(text: str, opened: int) -> int:
    """Index of the parenthesis that closes the one at `opened`."""
    depth = 0
    for i in range(opened, len(text)):
        depth += (text[i] == "(") - (text[i] == ")")
        if depth == 0:
            return i
    return len(text)


def count_parameters(text: str) -> int:
    """Number of parts between the commas that are outside of brackets."""
    depth, count = 0, 1
    for i, c in enumerate(text):
        depth += (c in "(<[{") - (c in ")]}" or (c == ">" and text[i - 1] != "-"))
        count += c == "," and depth == 0
    return count if text.strip() and text.strip() != "void" else 0


def without_template(head: str) -> str:
    """`head` without attributes and template parameters, which may have parentheses."""
    text = re.sub(r"\[\[.*?\]\]", "", head, flags=re.S).strip()
    while re.match(r"template\s*<", text):
        end, depth = text.index("<") + 1, 1
        while depth > 0:
            depth += (text[end] == "<") - (text[end] == ">")
            end += 1
        text = text[end:].strip()
    return text


@dataclass(frozen=True)
class Signature:
    name: str
    parameters: str
    rest: str  # after the parameters


def signature_of(head: str) -> Signature | None:
    """The signature that `head`, the text before a brace, ends with or contains; None if it is no function."""
    text = without_template(head)
    start = 0
    while (opened := text.find("(", start)) >= 0:
        before = text[:opened]
        if ANGLE.sub("", before).count("<") > ANGLE.sub("", before).count(">"):  # int(int) in std::function<int(int)>
            start = closing(text, opened) + 1
            continue
        if re.search(r"\boperator\s*$", before) and closing(text, opened) == opened + 1:  # operator()(…)
            name, opened = "operator()", text.find("(", opened + 2)
            before = re.sub(r"operator\s*$", "", before)
        elif named := NAME.search(before):
            name, before = named.group().strip(), before[:named.start()]
        else:
            return None
        end = closing(text, opened)
        if name not in NOT_NAMES:
            return None if "=" in before else Signature(name, text[opened + 1:end], text[end + 1:])
        start = end + 1
    return None


def is_value(head: str) -> bool:
    """Whether the brace after `head` opens a value: `int x{`, `= {`, or a member in the list of a constructor."""
    signature = signature_of(head)
    if signature is None:
        return True
    return bool(re.match(r"\s*(?:noexcept\s*)?:(?!:)", signature.rest)) and bool(re.search(r"[\w>]$", head.rstrip()))


def functions(source: str) -> list[Function]:
    """All functions that have a body, in the order of their ends."""
    found: list[Function] = []
    values = parentheses = body = 0  # how many are open
    head, first = "", 0
    signature = Signature("", "", "")
    line = 1
    for c in without_ignored(source):
        line += c == "\n"
        if body:
            body += (c == "{") - (c == "}")
            if body == 0:
                found.append(Function(signature.name, first, line - first + 1, count_parameters(signature.parameters)))
                head = ""
            continue
        if not head.strip():
            first = line
        parentheses += (c == "(") - (c == ")")
        if values and c not in "{}":
            continue
        if parentheses > 0 or c not in "{};":
            head += c
            if c == ":" and head.strip() in {"public:", "private:", "protected:"}:
                head = ""
        elif c == "{":
            if not values and SCOPE.match(without_template(head)):
                head = ""
            elif values or is_value(head):
                values += 1
            else:
                signature, body = signature_of(head) or signature, 1
        elif c == "}" and values:
            values -= 1
            head += c
        else:
            head = ""
    if values or parentheses or body:
        raise ValueError(f"The counter does not understand the source: {values} values, {parentheses} parentheses and {body} braces stay open.")
    return found
