#!/usr/bin/env python3
"""clang-tidy over the sources of the framework, the plugins and the tools.

usage: tidy.py BUILD_DIR [--tally FILE] [PATH_PART...]

A file that passed is not checked again until it, a header of ours that it includes, its compile command or .clang-tidy
changes: passes are kept by content in ${XDG_CACHE_HOME:-~/.cache}/aslio/tidy.
"""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = "clang-tidy-14"
ROOMS = ("framework/", "plugins/", "tools/")
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


def sources(build, parts):
    """(path relative to the root, compile command) of each source of ours, in order of path."""
    commands = json.loads((build / "compile_commands.json").read_text())
    found = {}
    for entry in commands:
        path = pathlib.Path(entry["directory"], entry["file"]).resolve()
        if path.is_relative_to(ROOT) and not path.is_relative_to(build):
            name = path.relative_to(ROOT).as_posix()
            if name.startswith(ROOMS) and (not parts or any(part in name for part in parts)):
                found.setdefault(name, entry["command"])
    return sorted(found.items())


def reachable(name, seen):
    """Adds to `seen` our headers that a file includes, directly or through others."""
    path = ROOT / name
    for include in INCLUDE.findall(path.read_text(encoding="utf-8")):
        for folder in (path.parent, ROOT / "framework/include", ROOT / "plugins", ROOT / "tools", ROOT):
            candidate = (folder / include).resolve()
            if candidate.is_file() and candidate.is_relative_to(ROOT):
                header = candidate.relative_to(ROOT).as_posix()
                if header not in seen:
                    seen.add(header)
                    reachable(header, seen)
                break


def digest(name, command, build):
    headers = set()
    reachable(name, headers)
    content = hashlib.sha256((ROOT / ".clang-tidy").read_bytes())
    # The clone and its build directory may lie anywhere.
    content.update(command.replace(str(build), "BUILD").replace(str(ROOT), "ROOT").encode())
    for file in [name, *sorted(headers)]:
        content.update(file.encode() + b"\0" + (ROOT / file).read_bytes())
    return content.hexdigest()


def check(name, build):
    """Findings of one file; empty when there are none."""
    # Warnings of the compiler proper are g++'s business (-Werror there); clang must only understand the code.
    run = subprocess.run([TOOL, "-p", str(build), "--quiet", "--extra-arg=-Wno-everything", "--extra-arg=-Wno-error",
                          str(ROOT / name)], capture_output=True, text=True, check=False)
    return "" if run.returncode == 0 else (run.stdout + run.stderr).strip() or f"{TOOL} ended with {run.returncode}"


def main(arguments):
    tally = None
    if "--tally" in arguments:
        at = arguments.index("--tally")
        tally = arguments[at + 1]
        del arguments[at:at + 2]
    if not arguments or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    begin = time.monotonic()
    build = pathlib.Path(arguments[0]).resolve()
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache", "aslio", "tidy")
    cache.mkdir(parents=True, exist_ok=True)
    files = sources(build, arguments[1:])
    keys = {name: cache / digest(name, command, build) for name, command in files}
    pending = [name for name, _ in files if not keys[name].exists()]
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, findings in zip(pending, pool.map(lambda name: check(name, build), pending)):
            if findings:
                failed += 1
                print(f"{name}:\n{findings}\n")
            else:
                keys[name].touch()
    print(f"clang-tidy: {len(files) - failed} files passed ({len(files) - len(pending)} unchanged since they last did), "
          f"{failed} failed, {time.monotonic() - begin:.0f} s")
    if not files:
        print("error: no sources in compile_commands.json", file=sys.stderr)
        failed = 1
    if tally:
        with open(tally, "a", encoding="utf-8") as file:
            file.write(f"clang-tidy\t{max(0, len(files) - failed)}\t{failed}\t0\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
