#!/usr/bin/env python3
"""Bundles the script and style of the page of `aslio report`; needs the npm registry once, and neither Node.js nor npm.

usage: bundle.py SOURCE WORK OUTPUT

Fetches the packages that package-lock.json names (with their digests) into WORK/node_modules, and has esbuild's own
program bundle SOURCE/src/main.js into OUTPUT/report.js and OUTPUT/report.css. Does nothing when no source has changed.
npm_config_registry names another registry than https://registry.npmjs.org.
"""
import base64
import hashlib
import io
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tarfile
import urllib.error
import urllib.request

MACHINES = {"x86_64": "linux-x64", "aarch64": "linux-arm64", "armv7l": "linux-arm", "ppc64le": "linux-ppc64", "riscv64": "linux-riscv64"}
TIMEOUT = 60  # [s]


class Failure(Exception):
    pass


def wanted(lock: dict) -> dict[str, dict]:
    """Folder in node_modules to package: all that the page is made of, and the esbuild of this machine."""
    machine = MACHINES.get(platform.machine())
    if machine is None:
        raise Failure(f"esbuild has no program for a {platform.machine()}; there are: {', '.join(MACHINES)}")
    packages = {}
    for path, package in lock["packages"].items():
        name = path.rpartition("node_modules/")[2]
        needed = path and not package.get("dev") and not package.get("optional") and name != "esbuild"
        if needed or name == f"@esbuild/{machine}":
            packages[path] = package
    return packages


def tarball(registry: str, path: str, package: dict) -> bytes:
    """The archive of a package, checked against its digest."""
    name = path.rpartition("node_modules/")[2]
    url = f"{registry.rstrip('/')}/{name}/-/{name.rpartition('/')[2]}-{package['version']}.tgz"
    try:
        with urllib.request.urlopen(url, timeout=TIMEOUT) as answer:
            data = answer.read()
    except (urllib.error.URLError, OSError) as error:
        raise Failure(f"{url}: {getattr(error, 'reason', error)}") from error
    kind, _, digest = package["integrity"].partition("-")
    if base64.b64encode(hashlib.new(kind, data).digest()).decode() != digest:
        raise Failure(f"{url}: not the package that package-lock.json names: its {kind} differs")
    return data


def unpack(data: bytes, folder: pathlib.Path) -> None:
    """Files below the archive's one folder; nothing outside of `folder`."""
    with tarfile.open(fileobj=io.BytesIO(data), mode="r:gz") as archive:
        for member in archive:
            parts = pathlib.PurePosixPath(member.name).parts[1:]
            if not member.isfile() or not parts or ".." in parts:
                continue
            target = folder.joinpath(*parts)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(archive.extractfile(member).read())
            target.chmod(0o755 if member.mode & 0o100 else 0o644)


def install(source: pathlib.Path, modules: pathlib.Path) -> pathlib.Path:
    """Fetches what is missing; the program of esbuild."""
    registry = os.environ.get("npm_config_registry") or "https://registry.npmjs.org"
    packages = wanted(json.loads((source / "package-lock.json").read_text()))
    for path, package in packages.items():
        folder = modules / path.removeprefix("node_modules/")
        mark = folder / ".integrity"
        if mark.is_file() and mark.read_text() == package["integrity"]:
            continue
        shutil.rmtree(folder, ignore_errors=True)
        unpack(tarball(registry, path, package), folder)
        mark.write_text(package["integrity"])
    return modules / next(p for p in packages if "@esbuild/" in p).removeprefix("node_modules/") / "bin/esbuild"


def bundle(esbuild: pathlib.Path, source: pathlib.Path, modules: pathlib.Path, output: pathlib.Path) -> None:
    command = [str(esbuild), f"report={source / 'src/main.js'}", f"--outdir={output}", "--bundle", "--minify", "--charset=ascii",
               "--format=iife", "--target=es2021,chrome100,firefox100,safari15", '--define:process.env.NODE_ENV="production"',
               "--legal-comments=eof", "--log-level=warning"]
    done = subprocess.run(command, env={**os.environ, "NODE_PATH": str(modules)}, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failure(f"esbuild: {done.stderr.strip()}")


def digest_of(source: pathlib.Path) -> str:
    files = sorted((source / "src").glob("*.js")) + sorted((source / "src").glob("*.css"))
    files += [source / "package.json", source / "package-lock.json", pathlib.Path(__file__)]
    return "".join(f"{hashlib.sha256(f.read_bytes()).hexdigest()} {f.name}\n" for f in files)


def main() -> int:
    source, work, output = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
    digest, known = digest_of(source), output / "sources.txt"
    made = [output / "report.js", output / "report.css"]
    if known.is_file() and known.read_text() == digest and all(f.is_file() for f in made):
        return 0
    output.mkdir(parents=True, exist_ok=True)
    try:
        bundle(install(source, work / "node_modules"), source, work / "node_modules", output)
    except Failure as error:
        for file in [*made, known]:
            file.unlink(missing_ok=True)
        (output / "missing.txt").write_text(f"{error}\n")
        print(error, file=sys.stderr)
        return 1
    (output / "missing.txt").unlink(missing_ok=True)
    known.write_text(digest)
    return 0


if __name__ == "__main__":
    sys.exit(main())
