#!/usr/bin/env python3
"""Load on a service of this machine: thousands of mixed requests, each answer checked.

    service/load_test.py PROGRAM [REQUESTS]

Starts PROGRAM serve on a free port of 127.0.0.1, asks for valid pictures of five formats, sends hostile and huge models, slow and
broken-off bodies, doubled, unsigned, wrongly signed and replayed requests, kills workers meanwhile, and ends the service under
load. Prints what it found as JSON, and ends with 1 if an answer was wrong, a worker was left, or memory grew. Standard library
only; nothing leaves this machine.
"""

import base64
import collections
import hashlib
import hmac
import http.client
import json
import math
import os
import random
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
MODELS = os.path.join(HERE, '..', 'assets', 'models')
KEY, SALT = b'\x0a\x0b', b'\x0c\x0d'
OLD_KEY, OLD_SALT = b'\x01', b'\x02'
CLIENTS = 12
MAX_BODY = 4 << 20
KILLS = 5


def read(name):
    with open(os.path.join(MODELS, name), 'rb') as file:
        return file.read()


def three_mf(folder):
    """A tetrahedron."""
    path = os.path.join(folder, 'a.3mf')
    model = ('<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
             '<resources><object id="1" type="model"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="9" y="0" z="0"/>'
             '<vertex x="0" y="9" z="0"/><vertex x="0" y="0" z="9"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/>'
             '<triangle v1="0" v2="1" v3="3"/><triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh>'
             '</object></resources><build><item objectid="1"/></build></model>')
    rels = ('<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
            'Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/3dmodel.model"/></Relationships>')
    kinds = ('<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default '
             'Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default '
             'Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')
    with zipfile.ZipFile(path, 'w') as archive:
        archive.writestr('[Content_Types].xml', kinds)
        archive.writestr('_rels/.rels', rels)
        archive.writestr('3D/3dmodel.model', model)
    with open(path, 'rb') as file:
        return file.read()


def hostile(rng):
    """Damaged, lying and exploding files; each may be a picture or a refusal, but nothing else."""
    glb = bytearray(read('rounded-cube.glb'))
    kind = rng.randrange(6)
    if kind == 0:
        return bytes(glb[:rng.randrange(4, len(glb))])
    if kind == 1:
        for _ in range(rng.randrange(1, 40)):
            glb[rng.randrange(12, len(glb))] = rng.randrange(256)
        return bytes(glb)
    if kind == 2:
        return b'\0' * 80 + struct.pack('<I', rng.randrange(1 << 31, (1 << 32) - 1)) + b'\0' * 50
    if kind == 3:
        return b'ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n' + rng.randbytes(100)
    if kind == 4:
        return b'{"asset":{"version":"2.0"},"nodes":[' + b'{"children":[0]},' * 1000 + b'{}]}'
    return b'v ' + rng.randbytes(200) + b'\nf 1 2 3\n'


class Service:
    def __init__(self, program, cache):
        command = [program, 'serve', '--listen', '127.0.0.1:0', '--cache', cache, '--cache-bytes', '20M', '--max-body', str(MAX_BODY),
                   '--key', f'{KEY.hex()},{OLD_KEY.hex()}', '--salt', f'{SALT.hex()},{OLD_SALT.hex()}', '--local', MODELS,
                   '--deadline', '20', '--queue', '200', '--queue-seconds', '60', '--body-seconds', '1', '--log', 'error',
                   '--models-of-worker', '200']
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        self.port = int(line.rsplit(':', 1)[1])
        self.pid = self.process.pid

    def request(self, method, path, body=None, headers=None):
        connection = http.client.HTTPConnection('127.0.0.1', self.port, timeout=120)
        try:
            connection.request(method, path, body, headers or {})
            answer = connection.getresponse()
            return answer.status, dict((k.lower(), v) for k, v in answer.getheaders()), answer.read()
        finally:
            connection.close()

    def memory(self):
        with open(f'/proc/{self.pid}/status', encoding='ascii') as file:
            return next(int(line.split()[1]) for line in file if line.startswith('VmRSS')) / 1024

    def workers(self):
        found = []
        for name in filter(str.isdigit, os.listdir('/proc')):
            try:
                with open(f'/proc/{name}/stat', encoding='utf-8') as file:
                    fields = file.read().rsplit(') ', 1)[1].split()
            except (OSError, IndexError):
                continue
            if int(fields[1]) == self.pid and fields[0] != 'Z':
                found.append(int(name))
        return found

    def cpu(self):
        """Seconds of processor time of this process, and of its children that have ended and are there."""
        own, children = 0.0, 0.0
        tick = os.sysconf('SC_CLK_TCK')
        for pid in [self.pid, *self.workers()]:
            try:
                with open(f'/proc/{pid}/stat', encoding='utf-8') as file:
                    fields = file.read().rsplit(') ', 1)[1].split()
            except OSError:
                continue
            used = (int(fields[11]) + int(fields[12])) / tick
            if pid == self.pid:
                own = used
                children += (int(fields[13]) + int(fields[14])) / tick
            else:
                children += used
        return own, children


def signed(path, key=KEY, salt=SALT):
    mac = hmac.new(key, salt + path.encode(), hashlib.sha256).digest()
    return '/' + base64.urlsafe_b64encode(mac).decode().rstrip('=') + path


class Load:
    def __init__(self, service, count, folder):
        self.service, self.count = service, count
        self.valid = {'glb': read('rounded-cube.glb'), 'stl': read('rounded-cube.stl'), 'ply': read('vase.ply'),
                      'obj': read('torus-knot.obj'), '3mf': three_mf(folder)}
        self.lock = threading.Lock()
        self.next = 0
        self.wrong, self.seen, self.times = [], collections.Counter(), collections.defaultdict(list)
        self.pictures, self.killed, self.memory = {}, 0, []

    def tell(self, kind, status, fine, about=''):
        with self.lock:
            self.seen[f'{kind} {status}'] += 1
            if not fine:
                self.wrong.append(f'{kind}: {status} {about}')

    def picture(self, kind, name, status, headers, body, size):
        """Whether it is the picture that was asked for, and the same as before."""
        if status == 500 and b'killed' in body and self.killed:
            return self.tell(kind, status, True)
        fine = status == 200 and body[:8] == b'\x89PNG\r\n\x1a\n' and struct.unpack('>II', body[16:24]) == (size, size)
        if fine:
            with self.lock:
                known = self.pictures.setdefault(name, (headers['etag'], hashlib.sha256(body).hexdigest()))
            fine = known == (headers['etag'], hashlib.sha256(body).hexdigest())
        return self.tell(kind, status, fine, body[:200])

    def timed(self, kind, *request):
        begun = time.monotonic()
        answer = self.service.request(*request)
        with self.lock:
            self.times[kind].append(time.monotonic() - begun)
        return answer

    def valid_request(self, rng):
        form, size = rng.choice(list(self.valid)), rng.randrange(32, 257)
        answer = self.timed('valid', 'POST', f'/render?size={size}&name=a.{form}', self.valid[form])
        self.picture('valid', (form, size), *answer, size)

    def double(self, rng):
        form, size = rng.choice(list(self.valid)), rng.choice((64, 65))
        answer = self.timed('double', 'POST', f'/render?size={size}&name=a.{form}', self.valid[form])
        self.picture('double', (form, size), *answer, size)

    def path(self, rng):
        size = rng.randrange(32, 129)
        key = rng.choice(((KEY, SALT), (OLD_KEY, OLD_SALT)))
        path = signed(f'/size:{size}/plain/local://rounded-cube.glb@png', *key)
        answer = self.timed('path', 'GET', path)
        self.picture('path', ('glb', size), *answer, size)
        if answer[0] == 200:
            status, _, body = self.service.request('GET', path, None, {'If-None-Match': answer[1]['etag']})
            self.tell('replayed', status, status == 304 and not body)

    def forged(self, rng):
        path = f'/size:{rng.randrange(32, 99)}/plain/local://rounded-cube.glb@png'
        given, expected = rng.choice((('/unsafe' + path, 401), (signed(path)[:-1] + 'G', 403), ('/AAAA' + path, 403),
                                      (signed(path.replace('cube', 'cubf')), 404), (signed('/size:9999/plain/local://a@png'), 400),
                                      (signed('/plain/http://127.0.0.1/a.glb@png'), 403)))
        status, _, _ = self.service.request('GET', given)
        self.tell('forged', status, status == expected, given)

    def hostile(self, rng):
        name = rng.choice(('a.glb', 'a.stl', 'a.ply', 'a.obj', 'a.3mf', 'a.gltf'))
        status, _, body = self.timed('hostile', 'POST', f'/render?size=64&name={name}', hostile(rng))
        fine = status in (200, 415, 422) or (status == 500 and b'killed' in body and self.killed)
        self.tell('hostile', status, fine, body[:200])

    def huge(self, rng):
        try:
            status, _, body = self.service.request('POST', '/render', b'v' * (MAX_BODY + rng.randrange(1, 1 << 20)))
            self.tell('huge', status, status == 413, body[:200])
        except (BrokenPipeError, ConnectionResetError) as error:
            self.tell('huge', 'broken', False, str(error))

    def wrong_options(self, rng):
        query = rng.choice(('size=0', 'size=4000', 'samples=5', 'format=gif', 'env=/etc/passwd', 'colour=red'))
        status, _, _ = self.service.request('POST', f'/render?{query}', self.valid['glb'])
        self.tell('options', status, status == 400, query)

    def raw(self, text):
        connection = socket.create_connection(('127.0.0.1', self.service.port), timeout=60)
        connection.sendall(text)
        return connection

    def slow(self, _):
        with self.raw(b'POST /render HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n\r\nglTF') as connection:
            answer = connection.recv(4096)
        self.tell('slow', answer[9:12].decode(), answer.startswith(b'HTTP/1.1 408'))

    def aborted(self, rng):
        model = self.valid['glb']
        head = f'POST /render?size={rng.randrange(32, 257)} HTTP/1.1\r\nHost: x\r\nContent-Length: {len(model)}\r\n\r\n'.encode()
        with self.raw(head) as connection:
            connection.sendall(model[:rng.choice((0, 10, len(model) // 2, len(model)))])
            time.sleep(rng.random() * 0.02)
        self.tell('aborted', 'gone', True)

    def kinds(self):
        weights = {self.valid_request: 50, self.double: 12, self.path: 10, self.hostile: 9, self.forged: 6, self.wrong_options: 5,
                   self.aborted: 4, self.huge: 2, self.slow: 2}
        return list(weights), list(weights.values())

    def client(self):
        kinds, weights = self.kinds()
        while True:
            with self.lock:
                number, self.next = self.next, self.next + 1
            if number >= self.count:
                return
            rng = random.Random(number)
            if number % max(1, self.count // 20) == 0:
                self.memory.append(round(self.service.memory(), 1))
            if number % max(1, self.count // KILLS) == self.count // (2 * KILLS):
                self.kill(rng)
            try:
                rng.choices(kinds, weights)[0](rng)
            except Exception as error:  # Whatever goes wrong is an answer that did not come.
                self.tell('client', type(error).__name__, False, str(error))

    def kill(self, rng):
        workers = self.service.workers()
        if workers:
            self.killed += 1
            try:
                os.kill(rng.choice(workers), signal.SIGKILL)
            except ProcessLookupError:
                pass

    def run(self):
        clients = [threading.Thread(target=self.client) for _ in range(CLIENTS)]
        for client in clients:
            client.start()
        for client in clients:
            client.join()


def sphere(rings=50, parts=52):
    """About five thousand triangles, as binary STL."""
    at = lambda r, p: (math.sin(math.pi * r / rings) * math.cos(2 * math.pi * p / parts),
                       math.sin(math.pi * r / rings) * math.sin(2 * math.pi * p / parts), math.cos(math.pi * r / rings))
    triangles = []
    for r in range(rings):
        for p in range(parts):
            a, b, c, d = at(r, p), at(r + 1, p), at(r + 1, p + 1), at(r, p + 1)
            triangles += ([(a, b, c)] if r < rings - 1 else []) + ([(a, c, d)] if r > 0 else [])
    body = b''.join(struct.pack('<12fH', 0, 0, 0, *a, *b, *c, 0) for a, b, c in triangles)
    return b'\0' * 80 + struct.pack('<I', len(triangles)) + body


def overhead(service):
    """Milliseconds of processor time that the service itself takes for a warm thumbnail, with a new key each time."""
    model, count = sphere(), 100
    triangles = json.loads(service.request('POST', '/info', model)[2])['triangles']
    for size in range(100, 104):
        service.request('POST', f'/render?size={size}', model)
    own, children = service.cpu()
    times = []
    for size in range(206, 206 + count):
        begun = time.monotonic()
        status, _, _ = service.request('POST', f'/render?size={size}', model)
        times.append(time.monotonic() - begun)
        assert status == 200, status
    own_after, children_after = service.cpu()
    return {'triangles': triangles, 'service_cpu_ms': round((own_after - own) / count * 1000, 2),
            'worker_cpu_ms': round((children_after - children) / count * 1000, 2),
            'p50_ms': round(sorted(times)[count // 2] * 1000, 1)}


def stop_under_load(service, models):
    """How many of the requests that were accepted got their picture after SIGTERM."""
    results = []

    def ask(size):
        try:
            results.append(service.request('POST', f'/render?size={size}&quality=good', models['stl'])[0])
        except ConnectionRefusedError:
            results.append('refused')
        except Exception as error:  # A lost request.
            results.append(type(error).__name__)

    clients = [threading.Thread(target=ask, args=(300 + k,)) for k in range(20)]
    for client in clients:
        client.start()
    time.sleep(0.15)
    workers = service.workers()
    service.process.send_signal(signal.SIGTERM)
    for client in clients:
        client.join()
    code = service.process.wait(60)
    time.sleep(1)
    left = [pid for pid in workers if os.path.exists(f'/proc/{pid}')]
    return collections.Counter(map(str, results)), code, left


def percentiles(times):
    times = sorted(times)
    at = lambda part: round(times[min(len(times) - 1, int(len(times) * part))] * 1000, 1)
    return {'count': len(times), 'p50_ms': at(0.5), 'p99_ms': at(0.99), 'max_ms': at(1)}


def main():
    program, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 10_000
    folder = tempfile.mkdtemp()
    try:
        service = Service(program, os.path.join(folder, 'cache'))
        cost = overhead(service)
        load = Load(service, count, folder)
        own, children = service.cpu()
        begun = time.monotonic()
        load.run()
        seconds = time.monotonic() - begun
        own_after, children_after = service.cpu()
        workers = len(service.workers())
        idle = service.memory()
        metrics = service.request('GET', '/metrics')[2].decode()
        stopped, code, left = stop_under_load(service, load.valid)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    # The first quarter fills what is kept; after that nothing grows.
    settled, last = max(load.memory[:len(load.memory) // 2]), max(load.memory[len(load.memory) // 2:])
    lost = {name: number for name, number in stopped.items() if name not in ('200', 'refused')}
    told = {
        'requests': count, 'seconds': round(seconds, 1), 'requests_per_second': round(count / seconds, 1),
        'overhead': cost, 'latency': {kind: percentiles(times) for kind, times in load.times.items()},
        'answers': dict(sorted(load.seen.items())), 'wrong': load.wrong[:20], 'wrong_count': len(load.wrong),
        'memory_mib': load.memory, 'memory_after_mib': round(idle, 1), 'workers': workers, 'workers_killed': load.killed,
        'cpu_seconds': {'service': round(own_after - own, 1), 'workers': round(children_after - children, 1)},
        'rendering_part': round((children_after - children) / (own_after - own + children_after - children), 3),
        'stop': {'answers': dict(stopped), 'code': code, 'workers_left': left},
        'metrics': [line for line in metrics.splitlines() if line.startswith(('overcoat_workers', 'overcoat_cache', 'overcoat_refusals'))],
    }
    print(json.dumps(told, indent=1))
    fine = not load.wrong and not left and not lost and code == 0 and last < settled * 1.25 + 16
    sys.exit(0 if fine else 1)


if __name__ == '__main__':
    main()
