#!/usr/bin/env python3
"""nginx.conf and Caddyfile in front of a service of this machine: what the book says of them.

    service/proxy_test.py PROGRAM [nginx|caddy]...

Starts PROGRAM serve on a socket of the machine, and each proxy with its file of this folder on a free port of 127.0.0.1, and looks for
equal pictures, the cache of signed paths, limits, large and slow bodies, the client's address, and what comes while the service is away
and when it is back. Needs the proxies (apt-get install nginx-light caddy); as root nginx gives up its rights, and the service
has its socket where it may reach it. Prints a line for each that holds, and ends with 1 at the first that does not.
"""

import base64
import hashlib
import hmac
import http.client
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
MODELS = os.path.join(HERE, '..', 'assets', 'models')
KEY, SALT = b'\x0a\x0b', b'\x0c\x0d'
MOST = 64 << 20


def free_port():
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


def signed(path):
    mac = hmac.new(KEY, SALT + path.encode(), hashlib.sha256).digest()
    return '/' + base64.urlsafe_b64encode(mac).decode().rstrip('=') + path


def ask(port, method, path, body=None, headers={}, source='127.0.0.1'):
    """Status, headers and body of the answer; an answer before the end of the body counts."""
    connection = http.client.HTTPConnection('127.0.0.1', port, timeout=60, source_address=(source, 0))
    try:
        try:
            connection.request(method, path, body, headers)
        except (BrokenPipeError, ConnectionResetError):
            pass
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read()
    finally:
        connection.close()


class Service:
    """The service behind the proxy."""

    def __init__(self, program, folder):
        self.program, self.folder, self.socket = program, folder, os.path.join(folder, 'overcoat.sock')
        self.metrics_port, self.process = free_port(), None

    def start(self):
        self.log = open(os.path.join(self.folder, 'log'), 'a+')
        self.process = subprocess.Popen(
            [self.program, 'serve', '--listen', f'unix:{self.socket}', '--metrics-listen', str(self.metrics_port), '--local', MODELS,
             '--trusted-proxies', '127.0.0.1', '--workers', '2', '--stop-seconds', '5'],
            env=dict(os.environ, OVERCOAT_KEY=KEY.hex(), OVERCOAT_SALT=SALT.hex()), stdout=subprocess.DEVNULL, stderr=self.log)

    def wait(self):
        end = time.monotonic() + 60
        while time.monotonic() < end:
            try:
                if ask(self.metrics_port, 'GET', '/ready')[0] == 200:
                    os.chmod(self.socket, 0o666)
                    return
            except OSError:
                pass
            time.sleep(0.05)
        sys.exit('the service does not start')

    def stop(self):
        self.process.terminate()
        self.process.wait()

    def metric(self, name):
        text = ask(self.metrics_port, 'GET', '/metrics')[2].decode()
        found = re.search(f'^{re.escape(name)} (.*)$', text, re.M)
        return float(found[1]) if found else 0.0

    def lines(self):
        with open(os.path.join(self.folder, 'log')) as log:
            return [json.loads(line) for line in log if line.startswith('{')]


def nginx(service, folder, port):
    with open(os.path.join(HERE, 'nginx.conf')) as file:
        text = file.read()
    for old, new in [('server 127.0.0.1:8080;', f'server unix:{service.socket};'), ('listen 80;', f'listen 127.0.0.1:{port};'),
                     ('    listen [::]:80;\n', ''), ('/var/cache/nginx/overcoat', f'{folder}/cache')]:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    temporary = ''.join(f'{kind}_temp_path {folder}/{kind};' for kind in ['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi'])
    path = os.path.join(folder, 'nginx.conf')
    with open(path, 'w') as file:
        file.write(f'daemon off; pid {folder}/pid; error_log {folder}/error.log; events {{}}\n'
                   f'http {{ access_log off; {temporary}\n{text}\n}}\n')
    command = ['nginx', '-p', folder, '-c', path]
    subprocess.run(command + ['-t', '-q'], check=True)
    return subprocess.Popen(command)


def caddy(service, folder, port):
    path = os.path.join(HERE, 'Caddyfile')
    formed = subprocess.run(['caddy', 'fmt', path], capture_output=True, text=True, check=True).stdout
    with open(path) as file:
        assert formed == file.read(), 'the Caddyfile is not as caddy fmt has it'
    environment = dict(os.environ, OVERCOAT_SITE=f'http://127.0.0.1:{port}', OVERCOAT_UPSTREAM=f'unix/{service.socket}',
                       CADDY_ADMIN=f'127.0.0.1:{free_port()}', XDG_DATA_HOME=folder, XDG_CONFIG_HOME=folder)
    with open(os.path.join(folder, 'caddy.log'), 'w') as log:
        return subprocess.Popen(['caddy', 'run', '--config', path, '--adapter', 'caddyfile'], env=environment, stderr=log)


def wait_for_port(port):
    end = time.monotonic() + 30
    while time.monotonic() < end:
        try:
            return socket.create_connection(('127.0.0.1', port)).close()
        except OSError:
            time.sleep(0.05)
    sys.exit('the proxy does not start')


def holds(what, is_so, *told):
    if not is_so:
        sys.exit(f'not so: {what} {told}')
    print(f'    {what}')


def pictures(service, port):
    """Equal pictures, whichever way they are asked for."""
    with open(os.path.join(MODELS, 'rounded-cube.glb'), 'rb') as file:
        cube = file.read()
    status, headers, uploaded = ask(port, 'POST', '/render?size=64', cube, {'X-Forwarded-For': '203.0.113.7'}, '127.0.0.2')
    holds('an upload is drawn', status == 200 and uploaded.startswith(b'\x89PNG'), status, uploaded[:200])
    line = next(line for line in service.lines() if line.get('id') == headers['X-Request-Id'])
    holds('the client is that of the connection to the proxy, whatever it says', line['client'] == '127.0.0.2', line)
    path = signed('/size:64/plain/local://rounded-cube.glb@png')
    holds('a signed path is the same picture', ask(port, 'GET', path)[2] == uploaded)
    encoded = base64.urlsafe_b64encode(b'local://rounded-cube.glb').decode().rstrip('=')
    holds('so is one in Base64', ask(port, 'GET', signed(f'/size:64/{encoded}.png'))[2] == uploaded)
    status, _, body = ask(port, 'GET', path.replace('64', '65'))
    holds('another signature is refused', status == 403, status, body)
    told = {kind: ask(port, 'GET', signed('/size:64/plain/local://rounded-cube.glb'), headers={'Accept': f'image/{kind}'})
            for kind in ['webp', 'png', 'webp', 'png']}
    holds('Accept chooses the format', all(told[kind][1]['Content-Type'] == f'image/{kind}' for kind in told))
    etag = told['png'][1]['ETag']
    status, _, body = ask(port, 'GET', path, headers={'If-None-Match': etag})
    holds('who has the picture is told so', (status, body) == (304, b''), status)


def bodies(service, port):
    status, _, _ = ask(port, 'POST', '/render', bytes(MOST - 1024))
    holds('a body as large as may be reaches the service', status == 415, status)
    before = service.metric('overcoat_requests_total{route="render",status="413"}')
    status, _, _ = ask(port, 'POST', '/render', bytes(MOST + 1024))
    holds('a larger one is refused', status == 413, status)
    return service.metric('overcoat_requests_total{route="render",status="413"}') - before


def away(service, port, path, cube):
    """What comes while the service is away; it is back in the end."""
    service.stop()
    begun = time.monotonic()
    status, _, _ = ask(port, 'POST', '/render?size=64', cube)
    holds(f'without the service an upload has 502 ({time.monotonic() - begun:.1f} s)', status == 502, status)
    stale = ask(port, 'GET', path)
    service.start()
    service.wait()
    end = time.monotonic() + 15
    while (status := ask(port, 'POST', '/render?size=64', cube)[0]) != 200 and time.monotonic() < end:
        time.sleep(0.2)
    holds('when it is back an upload is drawn', status == 200, status)
    return stale


def try_nginx(service, port):
    pictures(service, port)
    holds('nginx refuses the larger body itself', bodies(service, port) == 0)
    with open(os.path.join(MODELS, 'rounded-cube.glb'), 'rb') as file:
        cube = file.read()
    path = signed('/size:50/plain/local://rounded-cube.glb@png')
    asked = 'overcoat_requests_total{route="path",status="200"}'
    encoded = signed('/size:50/' + base64.urlsafe_b64encode(b'local://rounded-cube.glb').decode().rstrip('=') + '.png')
    first = ask(port, 'GET', path)[2]
    ask(port, 'GET', encoded)
    before = service.metric(asked)
    holds('signed paths come from the cache of nginx',
          ask(port, 'GET', path)[2] == ask(port, 'GET', encoded)[2] == first and service.metric(asked) == before)
    # Half a body, as a slow client sends it.
    connections = service.metric('overcoat_connections')
    slow = socket.create_connection(('127.0.0.1', port))
    slow.sendall(b'POST /render HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n\r\n' + bytes(50_000))
    time.sleep(0.5)
    holds('a slow body takes no connection of the service', service.metric('overcoat_connections') <= connections)
    slow.close()
    statuses = [ask(port, 'GET', '/formats')[0] for _ in range(60)]
    holds(f'of 60 requests at once {statuses.count(429)} are refused', set(statuses) == {200, 429}, statuses)
    holds('metrics are for this machine alone', ask(port, 'GET', '/metrics', source='127.0.0.2')[0] == 403)
    time.sleep(3)
    status, _, body = away(service, port, path, cube)
    holds('pictures of the cache are there meanwhile', (status, body) == (200, first), status)


def try_caddy(service, port):
    pictures(service, port)
    bodies(service, port)
    with open(os.path.join(MODELS, 'rounded-cube.glb'), 'rb') as file:
        cube = file.read()
    holds('metrics are for nobody', ask(port, 'GET', '/metrics')[0] == 403)
    path = signed('/size:50/plain/local://rounded-cube.glb@png')
    status, _, _ = away(service, port, path, cube)
    holds('signed paths are not there meanwhile', status == 502, status)
    service.stop()
    service.start()
    begun = time.monotonic()
    status, _, _ = ask(port, 'GET', path)
    holds(f'a service that is started anew is waited for ({time.monotonic() - begun:.1f} s)', status == 200, status)
    service.wait()


def main():
    program, names = os.path.abspath(sys.argv[1]), sys.argv[2:] or ['nginx', 'caddy']
    for name, start, check in [('nginx', nginx, try_nginx), ('caddy', caddy, try_caddy)]:
        if name not in names:
            continue
        if not shutil.which(name):
            sys.exit(f'there is no {name}')
        told = subprocess.run([name, '-v' if name == 'nginx' else 'version'], capture_output=True, text=True)
        print((told.stdout + told.stderr).strip())
        folder, port = tempfile.mkdtemp(), free_port()
        os.chmod(folder, 0o755)
        service, proxy = Service(program, folder), None
        try:
            service.start()
            service.wait()
            proxy = start(service, folder, port)
            wait_for_port(port)
            check(service, port)
        finally:
            for process in [proxy, service.process]:
                if process:
                    process.terminate()
                    process.wait()
            shutil.rmtree(folder)


if __name__ == '__main__':
    if len(sys.argv) < 2:
        sys.exit(__doc__.strip())
    main()
