#!/usr/bin/env python3
"""What previews.py keeps: examples/catalogue/previews_test.py PROGRAM [postgresql://...]

Starts PROGRAM serve on a folder of models, good ones, damaged ones and ones with awkward names, and fills a catalogue in SQLite (or in
the given database, whose tables files and previews must not be there) while it is interrupted, while the service is away, after
changes, and by several at once. Ends with 1 at the first thing that is not so.
"""

import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

HERE = os.path.dirname(os.path.abspath(__file__))
MODELS = os.path.join(HERE, '..', '..', 'assets', 'models')
sys.path.insert(0, HERE)
import previews  # noqa: E402


def free_port():
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


class Service:
    def __init__(self, program, folder):
        self.program, self.folder, self.port = program, folder, free_port()

    def start(self):
        command = [self.program, 'serve', '--listen', str(self.port), '--local', self.folder, '--allow-unsigned', '--log', 'error']
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        end = time.monotonic() + 60
        while time.monotonic() < end:
            try:
                return self.get('/ready')
            except OSError:
                time.sleep(0.05)
        sys.exit('the service does not start')

    def stop(self):
        self.process.terminate()
        self.process.wait()

    def get(self, path):
        with urllib.request.urlopen(f'http://127.0.0.1:{self.port}{path}') as answer:
            return answer.read().decode()

    def drawn(self):
        lines = self.get('/metrics').splitlines()
        return sum(float(line.split()[-1]) for line in lines if line.startswith('overcoat_render_seconds_count{stage="queue"}'))


def start(database, folder, service, *more):
    command = [sys.executable, os.path.join(HERE, 'previews.py'), database, folder, '--service', f'http://127.0.0.1:{service.port}']
    return subprocess.Popen(command + ['--options', 'size:48/quality:draft', *more], stdout=subprocess.PIPE, text=True)


def run(*args):
    process = start(*args)
    told, _ = process.communicate()
    assert process.returncode == 0, told
    return told


def main():
    program, folder = os.path.abspath(sys.argv[1]), tempfile.mkdtemp()
    models, database = os.path.join(folder, 'models'), os.path.join(folder, 'catalogue.db')
    database = sys.argv[2] if len(sys.argv) > 2 else database
    os.makedirs(os.path.join(models, 'below'))
    copy = lambda name, to: shutil.copy(os.path.join(MODELS, name), os.path.join(models, to))  # noqa: E731
    awkward = ['a b.glb', 'ü@x.glb', '100%23#?.glb', "'; DROP TABLE files; --.glb"]
    for name in awkward:
        copy('rounded-cube.glb', name)
    copy('vase.ply', 'below/vase.ply')
    copy('torus-knot.obj', 'below/torus-knot.obj')
    copy('torus-knot.mtl', 'below/torus-knot.mtl')
    shutil.copytree(os.path.join(MODELS, 'textures'), os.path.join(models, 'below', 'textures'))
    with open(os.path.join(models, 'broken.stl'), 'wb') as file:
        file.write(bytes(90))
    with open(os.path.join(models, 'text.txt'), 'w') as file:
        file.write('no model')
    service = Service(program, models)
    service.start()
    rows = lambda text: previews.Store(database).run(text)  # noqa: E731
    extensions = {extension for kind in json.loads(service.get('/formats'))['read'] for extension in kind['extensions']}
    try:
        # One that is killed while the service draws for it, then two at once.
        store = previews.Store(database)
        for table in previews.TABLES:
            store.run(table)
        first = start(database, models, service, '--workers', '1')
        while not store.run('SELECT path FROM files WHERE due > 0'):
            assert first.poll() is None, 'it has ended'
        first.kill()
        first.wait()
        # What it had taken is due when its time is over.
        store.run("UPDATE files SET due = 0 WHERE state = 'due'")
        two = [start(database, models, service) for _ in range(2)]
        for process in two:
            told, _ = process.communicate()
            assert process.returncode == 0, told
        told = run(database, models, service)
        assert told.splitlines() == ['6 drawn ', '1 failed model'], told
        pictures = rows('SELECT key, media_type, width, height, warnings, picture FROM previews')
        # Equal models have one preview, under whichever name.
        assert len(pictures) == 3, len(pictures)
        for _, media_type, width, height, warnings, picture in pictures:
            assert (media_type, width, height, json.loads(warnings)) == ('image/webp', 48, 48, []), warnings
            assert bytes(picture).startswith(b'RIFF')
        found = rows("SELECT path FROM files WHERE state = 'drawn'")
        assert {path for path, in found} == {*awkward, 'below/vase.ply', 'below/torus-knot.obj'}, found
        print('    everything is drawn once, whatever it is called and whoever was killed')

        before = service.drawn()
        run(database, models, service)
        assert service.drawn() == before
        print('    nothing is drawn where nothing has changed')

        copy('vase.glb', 'a b.glb')
        copy('rounded-cube.stl', 'broken.stl')
        os.remove(os.path.join(models, 'below/vase.ply'))
        assert run(database, models, service).splitlines() == ['6 drawn '], told
        assert len(rows('SELECT key FROM previews')) == 4
        assert service.drawn() == before + 2, service.drawn()
        print('    what has changed is drawn again, what is gone has no preview')

        os.remove(os.path.join(models, 'below/torus-knot.mtl'))
        old = rows("SELECT key FROM files WHERE path LIKE 'below%'")
        run(database, models, service, '--check')
        assert rows("SELECT key FROM files WHERE path LIKE 'below%'") != old
        assert service.drawn() <= before + 3 + len(awkward), service.drawn()
        print('    --check finds what has changed beside a model')

        copy('vase.ply', 'late.ply')
        previews.scan(store, models, extensions)
        service.stop()
        taken = previews.take(store)
        previews.draw(store, previews.Service(f'http://127.0.0.1:{service.port}', 'size:48'), taken)
        (state, kind, attempts), = rows("SELECT state, kind, attempts FROM files WHERE path = 'late.ply'")
        assert (taken[0], state, kind, attempts) == ('late.ply', 'due', 'away', 1), (taken, state, kind)
        service.start()
        run(database, models, service)
        (state, kind, attempts), = rows("SELECT state, kind, attempts FROM files WHERE path = 'late.ply'")
        assert (state, kind, attempts) == ('drawn', None, 0), (state, kind, attempts)
        print('    what has failed for want of the service is tried again')

        os.rename(models, models + '-away')
        os.mkdir(models)
        empty = start(database, models, service)
        empty.communicate()
        assert empty.returncode == 1 and rows('SELECT COUNT(*) FROM files') != [(0,)]
        print('    a folder without any model does not empty the catalogue')
    finally:
        service.stop()
        shutil.rmtree(folder)


if __name__ == '__main__':
    if len(sys.argv) < 2:
        sys.exit(__doc__.strip())
    main()
