#!/usr/bin/env python3
"""three.js in headless Chromium, drawn by SwiftShader.

The page is served from this process. Processor time is that of Chromium's process tree and this process, from /proc
in ticks of 10 ms; memory is the sum of the proportional set sizes at the end. CHROMIUM names the browser and
THREE_FOLDER the npm package `three`, if they are not found.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import common

HERE = Path(__file__).resolve().parent
PATIENCE = 600.0
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--no-first-run",
    "--disable-gpu",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-extensions",
    "--disable-sync",
    "--mute-audio",
)
KINDS = {".html": "text/html", ".js": "text/javascript", ".json": "application/json"}


def find():
    """The browser and the folder of three.js."""
    browser = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    if not browser or not shutil.which(browser):
        common.missing("no Chromium (apt install chromium, or set CHROMIUM)")
    folders = [os.environ.get("THREE_FOLDER"), "node_modules/three", HERE / "node_modules" / "three"]
    for folder in filter(None, folders):
        if (Path(folder) / "build" / "three.module.js").exists():
            return browser, Path(folder).resolve()
    common.missing("no three.js (npm install three, or set THREE_FOLDER to the package)")


def tree():
    """This process and all below it."""
    children = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                fields = Path("/proc", entry, "stat").read_text().rpartition(") ")[2].split()
            except OSError:
                continue
            children.setdefault(int(fields[1]), []).append((int(entry), fields))
    own = Path("/proc/self/stat").read_text().rpartition(") ")[2].split()
    found, todo = [], [(os.getpid(), own)]
    while todo:
        found.append(todo.pop())
        todo += children.get(found[-1][0], [])
    return found


def tree_time():
    """Processor seconds of the tree, with those of children that have ended."""
    return sum(int(field) for _, fields in tree() for field in fields[11:15]) / os.sysconf("SC_CLK_TCK")


def tree_memory():
    total = 0
    for process, _ in tree():
        try:
            text = Path("/proc", str(process), "smaps_rollup").read_text()
            total += int(re.search(r"^Pss:\s+(\d+)", text, re.MULTILINE).group(1))
        except (OSError, AttributeError):
            pass
    return total / 1024.0


class Task:
    """What the page is told, and what it tells."""

    def __init__(self, args, folder):
        self.args, self.folder = args, folder
        self.done = threading.Event()
        self.failure = None
        self.version = ""
        self.start = self.end = (0.0, 0.0)
        frames = args.frames if args.mode == "warm" else 1
        self.description = {
            "mode": args.mode,
            "width": args.width,
            "height": args.height,
            "samples": args.samples,
            "warm_up": args.warm_up,
            "models": len(args.model),
            "environment": bool(args.environment),
            "eyes": [common.eye(k, frames) for k in range(frames)],
            "field_of_view": common.FIELD_OF_VIEW,
            "near": common.NEAR,
            "far": common.FAR,
            "background": common.BACKGROUND,
        }

    def file(self, path):
        """What a path of the page stands for."""
        if path == "/":
            return HERE / "three.html"
        if path == "/environment.hdr":
            return Path(self.args.environment)
        if path.startswith("/model/"):
            return Path(self.args.model[int(path[7:])])
        if path.startswith("/three/"):
            return self.folder / path[7:]
        return None

    def told(self, path, body):
        if path == "/start":
            self.start = (tree_time(), time.perf_counter())
        elif path == "/picture":
            Path(self.args.picture).write_bytes(body)
        elif path == "/done":
            self.end = (tree_time(), time.perf_counter())
            self.version = body.decode()
            self.done.set()
        elif path == "/failed":
            self.failure = body.decode()
            self.done.set()


def handler(task):
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            if self.path == "/task.json":
                return self.answer(json.dumps(task.description).encode(), ".json")
            file = task.file(self.path)
            if file is None or not file.is_file():
                return self.send_error(404)
            return self.answer(file.read_bytes(), file.suffix)

        def do_POST(self):
            task.told(self.path, self.rfile.read(int(self.headers["Content-Length"] or 0)))
            self.answer(b"", ".json")

        def answer(self, body, suffix):
            self.send_response(200)
            self.send_header("Content-Type", KINDS.get(suffix, "application/octet-stream"))
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_):
            pass

    return Handler


def main():
    args = common.arguments(__doc__)
    browser, folder = find()
    if args.mode == "probe":
        chromium = subprocess.run([browser, "--version"], capture_output=True, text=True, check=True).stdout.strip()
        version = json.loads((folder / "package.json").read_text())["version"]
        common.finish({"peer": "three", "version": f"three.js {version}, {chromium}"})
        return
    task = Task(args, folder)
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler(task))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    profile = tempfile.mkdtemp(prefix="peer-three-")
    try:
        address = f"http://127.0.0.1:{server.server_address[1]}/"
        command = [browser, *OPTIONS, f"--user-data-dir={profile}", f"--window-size={args.width},{args.height}", address]
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            if not task.done.wait(PATIENCE):
                task.failure = f"nothing drawn after {PATIENCE:g} s"
            memory = tree_memory()
        finally:
            child.terminate()
            try:
                child.wait(20)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()
    finally:
        # Chromium may still be writing.
        shutil.rmtree(profile, ignore_errors=True)
    if task.failure:
        common.missing(f"three.js: {task.failure}")
    report = {"peer": "three", "version": task.version, "peak_mib": round(memory, 1), "tree_cpu_s": task.end[0]}
    if args.mode != "picture":
        count = args.frames if args.mode == "warm" else len(args.model)
        report["frames"] = count
        report["frame_cpu_ms"] = 1e3 * (task.end[0] - task.start[0]) / count
        report["frame_wall_ms"] = 1e3 * (task.end[1] - task.start[1]) / count
    common.finish(report)


if __name__ == "__main__":
    sys.exit(main())
