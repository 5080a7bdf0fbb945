#!/usr/bin/env python3
"""Compares overcoat with other renderers on this machine, by processor time.

All draw the same models with the same camera. Each round runs every renderer once, one after the other, so that a
change of the machine's speed meets all of them; medians over the rounds are told, and ratios are medians of the
ratios within a round. Writes results.json and table.md into the output folder.

  python3 benches/peers/compare.py --what cold,warm --rounds 5
  python3 benches/peers/compare.py --only overcoat,llvmpipe --what warm

A renderer that is not installed is left out with the reason. How to install them: benches/peers/README.md.
"""

import argparse
import json
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from datetime import datetime, timezone
from pathlib import Path

import common
import inputs
import pictures
import table
from workloads import (
    COLD,
    FRAMES,
    LARGE,
    LARGE_LEFT_OUT,
    SETTINGS,
    SIZE,
    TEXTURED,
    TEXTURED_FRAMES,
    TEXTURED_MODELS,
    WARM,
)

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PEERS = ("overcoat", "llvmpipe", "f3d", "vtk", "three")
KINDS = ("cold", "warm", "textured", "large", "models")
# A run that takes longer is ended and told.
PATIENCE = 900.0
# Share of pixels by which a peer's silhouette may differ from overcoat's.
SILHOUETTE = 0.01
OUR_SHADING = ["--shading", "urp-desktop", "--quality", "draft"]


class RunFailed(Exception):
    """A renderer ended with an error; the message is what it said."""


def command_line():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, prog="compare.py"
    )
    parser.add_argument(
        "--overcoat",
        metavar="PATH",
        help="the program [default: target/release/overcoat of this repository, else the one on PATH]",
    )
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="rounds that count [default: 5]")
    parser.add_argument("--only", metavar="NAME,...", help=f"renderers to run, of {', '.join(PEERS)} [default: all]")
    parser.add_argument(
        "--what",
        metavar="KIND,...",
        help="cold: start to PNG; warm: frames of an orbit; textured: the same with three textures and without; "
        "large: with 5M triangles; models: a new model each frame [default: all five]",
    )
    parser.add_argument(
        "--out",
        metavar="FOLDER",
        help="where models (150 MB with large), pictures and results go [default: target/peers of this repository]",
    )
    parser.add_argument(
        "--python",
        metavar="PATH",
        default=sys.executable,
        help="Python that has the peers' packages [default: the one that runs this script]",
    )
    args = parser.parse_args()
    if args.rounds < 1:
        parser.error("--rounds must be at least 1")
    args.only = chosen(parser, "--only", args.only, PEERS)
    args.what = chosen(parser, "--what", args.what, KINDS)
    args.out = Path(args.out) if args.out else ROOT / "target" / "peers"
    if "overcoat" in args.only:
        built = ROOT / "target" / "release" / "overcoat"
        args.overcoat = args.overcoat or (str(built) if built.exists() else shutil.which("overcoat"))
        if not args.overcoat:
            parser.error("no overcoat found: cargo build --release, or give --overcoat PATH")
        if not shutil.which(args.overcoat):
            parser.error(f"--overcoat: {args.overcoat} is no program")
    if not shutil.which(args.python):
        parser.error(f"--python: {args.python} is no program")
    return args


def chosen(parser, option, text, known):
    if text is None:
        return known
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in known:
            parser.error(f"{option}: {name!r} is none of {', '.join(known)}")
    return tuple(name for name in known if name in names)


def run(command, variables=(), memory=False):
    """Runs a program; (processor seconds of it and its children, wall seconds, standard output[, peak memory in MiB])."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        start = time.perf_counter()
        child = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, env={**os.environ, **dict(variables)}
        )
        late = threading.Timer(PATIENCE, child.kill)
        late.daemon = True
        late.start()
        try:
            _, status, usage = os.wait4(child.pid, 0)
        except BaseException:
            child.kill()
            raise
        finally:
            late.cancel()
        wall = time.perf_counter() - start
        child.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        output, errors = out.read().decode(errors="replace"), err.read().decode(errors="replace")
    if child.returncode:
        said = errors.strip().splitlines()[-1:] or [f"exit code {child.returncode}"]
        raise RunFailed(f"after {PATIENCE:g} s: ended" if wall > PATIENCE else said[0])
    found = (usage.ru_utime + usage.ru_stime, wall, output)
    return (*found, usage.ru_maxrss / 1024.0) if memory else found


def last_json(output):
    """The report of a run: the last line of a peer, or all that overcoat prints."""
    try:
        return json.loads(output)
    except ValueError:
        pass
    try:
        return json.loads(output.strip().splitlines()[-1])
    except (IndexError, ValueError):
        raise RunFailed("no report on standard output") from None


class Comparison:
    def __init__(self, args):
        self.args = args
        self.versions = {}
        self.left_out = {}
        self.commands = {}
        # Workload, then setting: one report for each round.
        self.runs = {}
        self.covered = {}
        self.notes = []
        self.rounds = 0
        self.load_before = load_average()

    # Commands

    def command(self, setting, mode, models, size=SIZE, frames=0, picture=None):
        environment = str(self.paths["environment"])
        models = [str(model) for model in models]
        if setting.peer != "overcoat":
            command = [self.args.python, str(HERE / f"peer_{setting.peer}.py"), mode, "--model", *models]
            command += ["--size", size, "--samples", str(setting.samples)]
            command += ["--environment", environment] if setting.environment else []
            command += ["--frames", str(frames)] if frames else []
            return command + (["--picture", str(picture)] if picture else [])
        light = "studio" if setting.built_in else environment if setting.environment else "none"
        command = [self.args.overcoat, "render" if picture else "bench", *models, *OUR_SHADING]
        command += ["--eye=" + ",".join(map(str, common.eye())), "--target", "0,0,0"]
        command += ["--fov", str(common.FIELD_OF_VIEW), "--env", light]
        command += ["--size", size, "--samples", str(setting.samples)]
        command += ["--anisotropy", str(setting.anisotropy)] if setting.anisotropy else []
        if picture:
            return command + ["-o", str(picture)]
        # One pass that is not counted comes before, as with the peers.
        count = ["--rounds", "1"] if mode == "models" else ["--frames", str(frames)]
        return command + [*count, "--image", "--json", "--quiet"]

    # Preparation

    def probe(self):
        """Finds the versions of what is installed."""
        for peer in self.args.only:
            try:
                if peer == "overcoat":
                    self.versions[peer] = run([self.args.overcoat, "--version"])[2].strip()
                else:
                    command = [self.args.python, str(HERE / f"peer_{peer}.py"), "probe"]
                    self.versions[peer] = last_json(run(command)[2])["version"]
                say(f"{peer}: {self.versions[peer]}")
            except RunFailed as failure:
                self.left_out[peer] = str(failure)
                say(f"{peer}: left out: {failure}")

    def settings(self, keys):
        return [SETTINGS[key] for key in keys if SETTINGS[key].peer in self.versions]

    def look(self):
        """One picture of every setting: fills caches on disk and shows that all draw the same silhouette."""
        for setting in self.settings([key for key in SETTINGS if key in COLD or key in FRAMES]):
            self.look_at(setting, setting.key, setting.key, self.paths["5k"])
        if "textured" in self.args.what:
            for setting in self.settings(TEXTURED):
                key = ("textured", setting.key)
                self.look_at(setting, f"{setting.key}-textured", key, self.paths["textured"])
        ours = self.covered.get("overcoat-8")
        for name, share in self.covered.items():
            if ours and abs(share - ours) > SILHOUETTE:
                self.note(f"{name} covers {share:.1%} of the pixels, overcoat {ours:.1%}: look at the pictures")

    def look_at(self, setting, name, key, model):
        """One picture; on failure what has the key is left out."""
        path = self.args.out / f"{name}.png"
        try:
            run(self.command(setting, "picture", [model], picture=path), setting.variables)
            self.covered[name] = pictures.covered(path)
            say(f"{path}: {self.covered[name]:.1%} covered")
        except (RunFailed, OSError, ValueError) as failure:
            self.note(f"{name} left out: {failure}")
            self.left_out[key] = str(failure)

    def note(self, text):
        self.notes.append(text)
        say(text)

    # Workloads

    def workloads(self):
        """Name, settings, and what makes a command of a setting."""
        model = lambda name: [self.paths[name]]
        if "cold" in self.args.what:
            picture = self.args.out / "cold.png"
            yield "cold", COLD, lambda s: self.command(s, "picture", model("5k"), picture=picture)
        if "warm" in self.args.what:
            for name, (size, knot, frames) in WARM.items():
                yield f"warm-{name}", FRAMES, lambda s, a=(knot, size, frames): self.command(
                    s, "warm", model(a[0]), a[1], a[2]
                )
        if "textured" in self.args.what:
            for name, knot in TEXTURED_MODELS.items():
                yield name, TEXTURED, lambda s, knot=knot: self.command(s, "warm", model(knot), SIZE, TEXTURED_FRAMES)
        if "large" in self.args.what:
            size, knot, frames = LARGE
            keys = [key for key in FRAMES if key not in LARGE_LEFT_OUT]
            yield "large", keys, lambda s: self.command(s, "warm", model(knot), size, frames)
        if "models" in self.args.what:
            yield "models", FRAMES, lambda s: self.command(s, "models", self.paths["models"])

    def measure(self):
        """All rounds; what stands is written after each."""
        workloads = list(self.workloads())
        for name, keys, command_of in workloads:
            self.commands[name] = {s.key: shlex.join(command_of(s)) for s in self.settings(keys)}
        for number in range(self.args.rounds):
            for name, keys, command_of in workloads:
                for setting in self.settings(keys):
                    if setting.key in self.left_out or (name, setting.key) in self.left_out:
                        continue
                    self.one(name, setting, command_of(setting), number)
            self.rounds = number + 1
            self.write()

    def one(self, name, setting, command, number):
        say(f"round {number + 1}/{self.args.rounds}  {name:<14}  {setting.key:<20}", end="")
        try:
            cpu, wall, output = run(command, setting.variables)
            report = last_json(output) if output.strip() else {}
        except RunFailed as failure:
            reason = str(failure)
            if name == "models" and setting.peer == "overcoat" and "unexpected argument" in reason:
                reason = "this version of overcoat bench takes one model only"
            say(f"  not available: {reason}")
            self.left_out[(name, setting.key)] = reason
            return
        entry = {"round": number, "cpu_s": report.get("tree_cpu_s", cpu), "wall_s": wall}
        entry["startup_cpu_s"] = report.get("startup_cpu_s", 0.0)
        frame = report.get("frame_cpu_ms", report.get("processor_ms"))
        if frame is not None:
            entry["frame_cpu_ms"] = frame
        if "peak_mib" in report:
            entry["peak_mib"] = report["peak_mib"]
        elif "peak_rss_bytes" in report:
            entry["peak_mib"] = report["peak_rss_bytes"] / 2**20
        elif setting.peer == "overcoat":
            # Its report costs time (a hash), so memory is asked for in a run that is not timed.
            entry["peak_mib"] = last_json(run([*command, "--json"])[2])["peak_rss_bytes"] / 2**20
        self.runs.setdefault(name, {}).setdefault(setting.key, []).append(entry)
        say(f"  {frame:9.2f} ms a frame" if frame is not None else f"  {entry['cpu_s']:9.3f} s")

    # Results

    def write(self):
        results = self.results()
        (self.args.out / "results.json").write_text(json.dumps(results, indent=1) + "\n")
        text = table.markdown(results)
        (self.args.out / "table.md").write_text(text)
        return text

    def results(self):
        options = ["--rounds", str(self.args.rounds), "--what", ",".join(self.args.what)]
        if self.args.only != PEERS:
            options += ["--only", ",".join(self.args.only)]
        return {
            "date": datetime.now(timezone.utc).strftime("%Y-%m-%d"),
            "rounds": self.rounds,
            "machine": machine(self.load_before),
            "versions": self.versions,
            "left_out": {"/".join(k) if isinstance(k, tuple) else k: v for k, v in self.left_out.items()},
            "notes": self.notes,
            "covered": self.covered,
            "command": shlex.join(["python3", "benches/peers/compare.py", *options]),
            "commands": self.commands,
            "runs": self.runs,
        }


def machine(load_before):
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as file:
            names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
        model = names[0] if names else model
    except OSError:
        pass
    return {
        "cpu": model,
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "kernel": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "load_before": load_before,
        "load_after": load_average(),
    }


def load_average():
    """Over 1, 5 and 15 minutes."""
    return [round(value, 2) for value in os.getloadavg()]


def say(text, end="\n"):
    print(text, end=end, flush=True)


def main():
    args = command_line()
    args.out.mkdir(parents=True, exist_ok=True)
    knots = {"5k"}
    if "warm" in args.what:
        knots |= {knot for _, knot, _ in WARM.values()}
    if "large" in args.what:
        knots.add(LARGE[1])
    comparison = Comparison(args)
    comparison.probe()
    if not comparison.versions:
        sys.exit("compare.py: none of the renderers is installed; see benches/peers/README.md")
    comparison.paths = inputs.make(
        args.out, sorted(knots), models="models" in args.what, textured="textured" in args.what, say=say
    )
    stopped = False
    try:
        comparison.look()
        comparison.measure()
    except KeyboardInterrupt:
        stopped = True
        comparison.note("stopped before all rounds were done")
    text = comparison.write()
    say(f"\n{text}\nwritten: {args.out / 'table.md'}, {args.out / 'results.json'}")
    sys.exit(130 if stopped else 0)


if __name__ == "__main__":
    main()
