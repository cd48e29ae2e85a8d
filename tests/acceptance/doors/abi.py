"""abi.py PREFIX: what programs that were linked to libtypodont.so rely on, a line each: versioned symbols, sizes of structs, and
type size and place of their members, as the compiler lays them out; values of constants."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

prefix = Path(sys.argv[1])
headers = ["typodont.h", "typodont_sound.h", "typodont_calibration.h"]
text = "".join(re.sub(r"/\*.*?\*/", "", (prefix / "include" / h).read_text(), flags=re.S) for h in headers)

program = ["#include <stddef.h>", "#include <stdio.h>"] + [f"#include <{h}>" for h in headers] + ["int main(void) {"]
for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\} \1;", text, flags=re.S):
    program.append(f'  printf("struct {name} %zu\\n", sizeof({name}));')
    for declaration in filter(None, (part.strip() for part in body.split(";"))):
        for member in declaration.split(","):
            field = re.search(r"(\w+)(\[\w+\])?$", member.strip()).group(1)
            program.append(f'  printf("member {name}.{field} %zu at %zu\\n", sizeof((({name}*)0)->{field}), '
                           f'offsetof({name}, {field}));')
for body in re.findall(r"\benum \{(.*?)\}", text, flags=re.S):
    for constant in re.findall(r"(\w+)\s*=", body):
        program.append(f'  printf("constant {constant} %d\\n", {constant});')
program.append("  return 0;\n}")

with tempfile.TemporaryDirectory() as place:
    source = Path(place) / "layout.c"
    source.write_text("\n".join(program))
    subprocess.run(["cc", "-I", prefix / "include", source, "-o", f"{place}/layout"], check=True)
    print(subprocess.run([f"{place}/layout"], check=True, capture_output=True, text=True).stdout, end="")
library = next(iter(sorted(prefix.glob("lib*/**/libtypodont.so.0"))))
symbols = subprocess.run(["nm", "-D", "--defined-only", "--with-symbol-versions", library], check=True, capture_output=True, text=True)
for line in sorted(line.split()[2] for line in symbols.stdout.splitlines()):
    if "@@" in line:
        print(f"symbol {line}")
    elif not line.startswith("TYPODONT_"):
        print(f"unversioned {line}")
