#!/usr/bin/env python3
"""Measures how the source reads: lengths of functions, comments, public modules, sizes of structs.

    tools/measure_house.py [ROOT] [--list] [--tests]

Prints a Markdown table of the Rust files below ROOT/src (default: the folder above this file). Lines of a function run from
`fn` to its closing brace. A comment inside is `//` or `/* */` on any of these lines. Test modules and files are left out
unless `--tests` is given. `--list` names the functions over 30 lines with no comment inside, longest first, and the
largest structs. Standard library only.
"""

import argparse
import re
from dataclasses import dataclass
from pathlib import Path
from statistics import median

# A function of more lines should say what its steps are.
LONG = 30

TOKEN = re.compile(
    r"""(?P<doc>//[/!][^\n]*)
      | (?P<comment>//[^\n]*|/\*.*?\*/)
      | (?P<text>b?r(?P<hashes>\#*)".*?"(?P=hashes)|b?"(?:\\.|[^"\\])*"|b?'(?:\\(?:u\{[^}]*\}|x..|.)|[^\\'\n])')
      | (?P<word>'?[A-Za-z_][A-Za-z0-9_]*|[0-9][A-Za-z0-9_.]*)
      | (?P<sign>->|=>|[^\s\w])""",
    re.VERBOSE | re.DOTALL,
)

CLUMSY_RATE = re.compile(r"\b(a|one|few) [a-z]+ a (texel|site|vertex|label|level|subcommand|pixel)\b")


@dataclass
class Token:
    kind: str
    text: str
    line: int


@dataclass
class Function:
    name: str
    file: Path
    first: int
    last: int
    commented: bool

    @property
    def lines(self):
        return self.last - self.first + 1


@dataclass
class Struct:
    name: str
    file: Path
    line: int
    fields: int


def tokens_of(text):
    tokens, line, at = [], 1, 0
    for match in TOKEN.finditer(text):
        line += text.count("\n", at, match.start())
        at = match.start()
        tokens.append(Token(match.lastgroup if match.lastgroup != "hashes" else "text", match.group(), line))
    return tokens


def closing(code, opening):
    """The position of the brace that closes the one at `opening`."""
    depth = 0
    for at in range(opening, len(code)):
        if code[at].text in ("{", "}"):
            depth += 1 if code[at].text == "{" else -1
            if depth == 0:
                return at
    raise ValueError("a brace that nothing closes")


def body_of(code, at):
    """The position of the `{` that opens the body of an item, or None where `;` ends it."""
    depth = 0
    for here in range(at, len(code)):
        text = code[here].text
        if text in ("(", "["):
            depth += 1
        elif text in (")", "]"):
            depth -= 1
        elif depth == 0 and text == ";":
            return None
        elif depth == 0 and text == "{":
            return here
    return None


def without_tests(code):
    """The tokens without the modules that `#[cfg(test)]` stands before."""
    kept, at = [], 0
    while at < len(code):
        if [token.text for token in code[at : at + 7]] == ["#", "[", "cfg", "(", "test", ")", "]"]:
            body = body_of(code, at + 7)
            after = next(here for here in range(at + 7, len(code)) if code[here].text in (";", "{"))
            at = (closing(code, body) if body == after else after) + 1
        else:
            kept.append(code[at])
            at += 1
    return kept


def functions_of(file, code, comments):
    for at, token in enumerate(code):
        if token.text == "fn" and code[at + 1].kind == "word":
            body = body_of(code, at)
            if body is not None:
                first, last = token.line, code[closing(code, body)].line
                commented = any(first <= line <= last for line in comments)
                yield Function(code[at + 1].text, file, first, last, commented)


def structs_of(file, code):
    for at, token in enumerate(code):
        body = body_of(code, at) if token.text == "struct" and code[at + 1].kind == "word" else None
        if body is not None and "(" not in [other.text for other in code[at:body]]:
            depth, fields = 0, 0
            for here in range(body, closing(code, body)):
                text = code[here].text
                depth += (text in "{([") - (text in "})]")
                # `name: Type`, but no `::` of a path.
                colon = text == ":" and code[here + 1].text != ":" and code[here - 1].text != ":"
                fields += depth == 1 and colon and code[here - 1].kind == "word"
            yield Struct(code[at + 1].text, file, token.line, fields)


def share(part, whole):
    return f"{100 * part / max(whole, 1):.1f} %"


def is_test(file):
    return file.stem.endswith("tests") or "tests" in file.parts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).resolve().parent.parent)
    parser.add_argument("--list", action="store_true", help="name what the table counts")
    parser.add_argument("--tests", action="store_true", help="count test modules and files too")
    args = parser.parse_args()

    functions, structs, lines, doc, plain, public, fences = [], [], 0, 0, 0, 0, 0
    for file in sorted((args.root / "src").rglob("*.rs")):
        text, name = file.read_text(), file.relative_to(args.root)
        lines += text.count("\n")
        public += len(re.findall(r"^pub mod", text, re.MULTILINE))
        fences += len(re.findall(r"^\s*//[/!] ?```(?:$|no_run|should_panic|rust)", text, re.MULTILINE)) // 2
        tokens = tokens_of(text)
        doc += sum(token.kind == "doc" for token in tokens)
        comments = {token.line for token in tokens if token.kind == "comment"}
        plain += len(comments)
        if args.tests or not is_test(name):
            code = [token for token in tokens if token.kind not in ("doc", "comment")]
            code = code if args.tests else without_tests(code)
            functions += functions_of(name, code, comments)
            structs += structs_of(name, code)

    texts = [*(args.root / "src").rglob("*.rs"), *(args.root / "docs").rglob("*.md"), args.root / "README.md"]
    clumsy = [
        f"{file.relative_to(args.root)}:{number}: {line.strip()}"
        for file in texts
        if file.is_file()
        for number, line in enumerate(file.read_text().splitlines(), 1)
        for _ in CLUMSY_RATE.finditer(line)
    ]
    lengths = sorted(function.lines for function in functions)
    long = sorted((f for f in functions if f.lines > LONG), key=lambda f: -f.lines)
    mute = [function for function in long if not function.commented]
    structs.sort(key=lambda struct: -struct.fields)

    print("| figure | value |\n| --- | --- |")
    print(f"| functions | {len(lengths)} |")
    print(f"| function median / p90 / max, lines | {median(lengths):g} / {lengths[len(lengths) * 9 // 10]} / {lengths[-1]} |")
    print(f"| functions over {LONG} lines | {len(long)} |")
    print(f"| of these without one comment inside | {len(mute)}, {share(len(mute), len(long))} |")
    print(f"| doc / plain comments | {share(doc, lines)} / {share(plain, lines)} |")
    print(f"| `pub mod` | {public} |")
    print(f"| doc-test fences | {fences} |")
    print(f"| largest struct, fields | {structs[0].fields} (`{structs[0].name}`) |")
    print(f"| \"a … a texel\" for \"… per texel\" | {len(clumsy)} |")
    if args.list:
        print(f"\nFunctions over {LONG} lines without a comment inside:\n")
        for function in mute:
            print(f"- {function.lines} `{function.name}` {function.file}:{function.first}")
        print("\nLargest structs:\n")
        for struct in structs[:12]:
            print(f"- {struct.fields} `{struct.name}` {struct.file}:{struct.line}")
        print("\n\"a … a texel\":\n")
        for line in clumsy:
            print(f"- {line}")


if __name__ == "__main__":
    main()
