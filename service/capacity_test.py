#!/usr/bin/env python3
"""What a service of this machine does beyond its capacity, and to a cheap client beside a greedy one.

    service/capacity_test.py PROGRAM [SECONDS]

Starts PROGRAM serve on a free port of 127.0.0.1 and measures what it answers when it is asked as fast as it answers (its capacity),
then sends half, once, twice and four times as many requests a second for SECONDS each (10), at times of a seeded Poisson process,
whether answers have come or not: 80 percent cheap ones, 10 percent dear ones, 10 percent hostile models, from eight addresses of
127.0.0.0/8. Then it measures a cheap client alone, and beside a greedy one with 16 dear requests under way at all times. Prints JSON;
ends with 1 if an answer is neither a picture nor a refusal by name. Standard library only; nothing leaves this machine.
"""

import collections
import http.client
import json
import random
import subprocess
import sys
import threading
import time

from load_test import hostile, percentiles, read

CHEAP, DEAR = '/render?size=128&quality=draft', '/render?size=512&quality=good'
REFUSED = (429, 503)


class Service:
    def __init__(self, program, *more):
        command = [program, 'serve', '--listen', '127.0.0.1:0', '--log', 'error', '--queue', '32', '--queue-seconds', '10', *more]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.port = int(self.process.stdout.readline().rsplit(':', 1)[1])
        self.model = read('rounded-cube.glb')
        self.lock = threading.Lock()

    def ask(self, kind, number, address):
        """Status, whether it tells when to come again, and seconds. No two pictures are equal."""
        path = DEAR if kind == 'dear' else CHEAP
        body = hostile(random.Random(number)) if kind == 'hostile' else self.model
        begun = time.monotonic()
        connection = http.client.HTTPConnection('127.0.0.1', self.port, timeout=120, source_address=(address, 0))
        try:
            connection.request('POST', f'{path}&background={number % (1 << 24):06x}', body)
            answer = connection.getresponse()
            answer.read()
            return answer.status, answer.getheader('Retry-After') is not None, time.monotonic() - begun
        finally:
            connection.close()

    def stop(self):
        self.process.terminate()
        self.process.wait(60)


def mix(rng):
    return rng.choices(('cheap', 'dear', 'hostile'), (80, 10, 10))[0]


def answers(service, seconds, clients=6):
    """Requests that are answered a second, where each client asks when it has its answer."""
    end, counts = time.monotonic() + seconds, [0] * clients

    def client(k):
        rng = random.Random(k)
        while time.monotonic() < end:
            service.ask(mix(rng), rng.randrange(1 << 24), f'127.0.1.{k + 1}')
            counts[k] += 1

    threads = [threading.Thread(target=client, args=(k,)) for k in range(clients)]
    begun = time.monotonic()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return sum(counts) / (time.monotonic() - begun)


def offered(service, rate, seconds, seed):
    """Requests at a rate, whatever comes back."""
    rng, found, times, wrong = random.Random(seed), collections.Counter(), collections.defaultdict(list), []
    threads, begun, at = [], time.monotonic(), 0.0

    def one(kind, number, address):
        try:
            status, tells, took = service.ask(kind, number, address)
        except Exception as error:  # Whatever goes wrong is an answer that did not come.
            wrong.append(f'{kind}: {type(error).__name__} {error}')
            return
        with service.lock:
            if status == 200 and kind != 'hostile':
                found[f'{kind} good'] += 1
                times[kind].append(took)
            elif status in REFUSED and tells:
                found[f'{kind} refused'] += 1
                times['refused'].append(took)
            elif kind == 'hostile' and status in (200, 415, 422, 429):
                found['hostile answered'] += 1
            else:
                wrong.append(f'{kind}: {status}')

    while True:
        at += rng.expovariate(rate)
        if at > seconds:
            break
        time.sleep(max(0.0, begun + at - time.monotonic()))
        thread = threading.Thread(target=one, args=(mix(rng), rng.randrange(1 << 24), f'127.0.1.{rng.randrange(1, 9)}'))
        thread.start()
        threads.append(thread)
    for thread in threads:
        thread.join()
    took = time.monotonic() - begun
    good = found['cheap good'] + found['dear good']
    return {'offered_per_second': round(len(threads) / seconds, 1), 'good_per_second': round(good / took, 1), **dict(sorted(found.items())),
            'latency': {kind: percentiles(all_of) for kind, all_of in times.items()}}, wrong


def fairness(program, seconds, *more):
    """Percentiles of a cheap client alone and beside a greedy one."""
    service = Service(program, *more)
    stop = threading.Event()

    def cheap(seed):
        rng, times, end = random.Random(seed), [], time.monotonic() + seconds
        while time.monotonic() < end:
            status, _, took = service.ask('cheap', rng.randrange(1 << 24), '127.0.2.1')
            assert status == 200, status
            times.append(took)
        return percentiles(times)

    def greedy(k):
        rng = random.Random(1000 + k)
        while not stop.is_set():
            service.ask('dear', rng.randrange(1 << 24), '127.0.2.2')

    try:
        alone = cheap(1)
        threads = [threading.Thread(target=greedy, args=(k,)) for k in range(16)]
        for thread in threads:
            thread.start()
        time.sleep(1)
        beside = cheap(2)
        stop.set()
        for thread in threads:
            thread.join()
    finally:
        service.stop()
    return {'options': ' '.join(more), 'alone': alone, 'beside': beside, 'p99_ratio': round(beside['p99_ms'] / alone['p99_ms'], 2)}


def main():
    program, seconds = sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 10.0
    service = Service(program)
    try:
        answers(service, 1)
        capacity = answers(service, seconds)
        told, wrong = {'capacity_per_second': round(capacity, 1), 'load': {}}, []
        for factor in (0.5, 1, 2, 4):
            told['load'][factor], more = offered(service, capacity * factor, seconds, int(factor * 10))
            wrong += more
    finally:
        service.stop()
    told['fairness'] = [fairness(program, seconds, *more) for more in ((), ('--client-workers', '1'), ('--spare-workers', '0'))]
    told['wrong'] = wrong[:20]
    print(json.dumps(told, indent=1))
    sys.exit(1 if wrong else 0)


if __name__ == '__main__':
    main()
