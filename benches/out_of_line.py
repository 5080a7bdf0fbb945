#!/usr/bin/env python3
"""Lane arithmetic that was not inlined: functions that call the kernels of an instruction set one by one.

Usage:  cargo build --profile profiling -p overcoat-cli && benches/out_of_line.py [target/profiling/overcoat]

A closure or function that is compiled without the instruction set of `Lanes::run` cannot inline its arithmetic: each addition is a
call, with the same bits. Prints the number of such calls in each function of the program, the most first, and
the functions that call it. Needs objdump. The remedy is a function with `inline(always)`, `each!`, or `match` in place of `map`.
"""
import collections
import re
import subprocess
import sys

KERNEL = "__fearless_simd_kernel"


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "target/profiling/overcoat"
    objdump = ["objdump", "--disassemble", "--no-show-raw-insn", "--demangle", program]
    kernels, callers, names, at = collections.Counter(), collections.defaultdict(collections.Counter), {}, None
    with subprocess.Popen(objdump, stdout=subprocess.PIPE, text=True) as lines:
        for line in lines.stdout:
            if head := re.match(r"([0-9a-f]+) <(.*)>:$", line):
                at = int(head[1], 16)
                names[at] = head[2]
            elif call := re.search(r"\b(?:call|jmp)\s+([0-9a-f]+) <(.*)>", line):
                if KERNEL in call[2]:
                    kernels[at] += 1
                elif int(call[1], 16) != at:
                    callers[int(call[1], 16)][at] += 1
    if not names:
        sys.exit(f"{program}: no functions (is it stripped?)")
    for function, count in kernels.most_common():
        print(f"{count:6} {names[function][:150]}")
        for caller in callers[function]:
            print(f"         from {names[caller][:140]}")


if __name__ == "__main__":
    main()
