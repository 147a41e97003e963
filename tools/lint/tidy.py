#!/usr/bin/env python3
"""clang-tidy over the sources of the framework, the plugins and the tools.

usage: tidy.py BUILD_DIR [--tally FILE] [PATH_PART...]

Up to eight sources that share no name are checked as one, and each by itself where that finds something. They are read
without the precompiled headers of the build.
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
sys.path.insert(0, str(ROOT / "tools/lib"))
import neighbours

TOOL = "clang-tidy-14"
MODULES = ("framework/", "plugins/", "tools/")


def members(entry, build):
    """The sources that a compile command is for: one, or those of a file that includes them (ASLIO_UNITY)."""
    path = pathlib.Path(entry["directory"], entry["file"]).resolve()
    if path.is_relative_to(build) and path.parent.name == "Unity":
        return [pathlib.Path(member).resolve() for member in neighbours.INCLUDE.findall(path.read_text(encoding="utf-8"))]
    return [path]


def sources(build, parts):
    """Batches of our sources that take the same options and share no name: lists of (path relative to the root, a compile
    command of its own)."""
    alike, seen = {}, set()
    for entry in json.loads((build / "compile_commands.json").read_text()):
        for file in members(entry, build):
            name = file.relative_to(ROOT).as_posix() if file.is_relative_to(ROOT) and not file.is_relative_to(build) else ""
            if not name.startswith(MODULES) or name in seen or parts and not any(part in name for part in parts):
                continue
            seen.add(name)
            # Without its output, which names what else is compiled, and without precompiled headers.
            command = re.sub(r" -Winvalid-pch| -Wno-subobject-linkage| -include \S+cmake_pch\S*| -(o|MT|MF) \S+| -MD", "", entry["command"])
            of_it = (name, command.replace(entry["file"], str(file)))
            alike.setdefault(command.replace(entry["file"], "SOURCE"), {})[str(file)] = of_it
    return sorted([files[path] for path in group] for files in alike.values() for group in neighbours.groups(sorted(files)))


def digest(name, command, build):
    headers = {path.relative_to(ROOT).as_posix() for path in neighbours.reachable(ROOT / name)}
    content = hashlib.sha256((ROOT / ".clang-tidy").read_bytes())
    # The clone and its build directory may lie anywhere.
    content.update(command.replace(str(build), "BUILD").replace(str(ROOT), "ROOT").encode())
    for file in [name, *sorted(headers)]:
        content.update(file.encode() + b"\0" + (ROOT / file).read_bytes())
    return content.hexdigest()


def findings(file, folder, *options):
    """What clang-tidy finds in a file that the compile commands of `folder` name; empty when that is nothing."""
    # Warnings of the compiler proper are g++'s business (-Werror there); clang must only understand the code.
    run = subprocess.run([TOOL, "-p", str(folder), "--quiet", *options, "--extra-arg=-Wno-everything",
                          "--extra-arg=-Wno-error", str(file)], capture_output=True, text=True, check=False)
    return "" if run.returncode == 0 else (run.stdout + run.stderr).strip() or f"{TOOL} ended with {run.returncode}"


def check(batch, folder):
    """{path: findings} of some sources. As one file they take the time of one, most of which is spent on the headers; only
    where that has findings is each looked at by itself. `folder`: of their compile commands, and for that file."""
    if len(batch) > 1:
        first, command = batch[0]
        own = folder / hashlib.sha256("".join(name for name, _ in batch).encode()).hexdigest()[:16]
        own.mkdir(exist_ok=True)
        together = own / "together.cpp"
        together.write_text("".join(f'#include "{ROOT / name}"\n' for name, _ in batch), encoding="utf-8")
        write_commands(own, [(together, command.replace(str(ROOT / first), str(together)))])
        if not findings(together, own, "--checks=-bugprone-suspicious-include"):
            return {name: "" for name, _ in batch}
    return {name: findings(ROOT / name, folder) for name, _ in batch}


def write_commands(folder, commands):
    """compile_commands.json of (file, command); the commands name files in full."""
    entries = [{"directory": str(folder), "command": command, "file": str(file)} for file, command in commands]
    (folder / "compile_commands.json").write_text(json.dumps(entries, indent=1), encoding="utf-8")


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
    batches = sources(build, arguments[1:])
    files = [file for batch in batches for file in batch]
    keys = {name: cache / digest(name, command, build) for name, command in files}
    pending = [[file for file in batch if not keys[file[0]].exists()] for batch in batches]
    unchanged = len(files) - sum(map(len, pending))
    folder = build / "tidy"
    folder.mkdir(exist_ok=True)
    write_commands(folder, [(ROOT / name, command) for name, command in files])
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for results in pool.map(lambda batch: check(batch, folder), [batch for batch in pending if batch]):
            for name, found in results.items():
                if found:
                    failed += 1
                    print(f"{name}:\n{found}\n")
                else:
                    keys[name].touch()
    print(f"clang-tidy: {len(files) - failed} files passed ({unchanged} unchanged since they last did), "
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
