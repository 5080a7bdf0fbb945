#!/usr/bin/env python3
"""A catalogue of models with their previews, in SQLite or PostgreSQL, kept up to date by overcoat-service.

    overcoat-service serve --local FOLDER --allow-unsigned
    previews.py DATABASE FOLDER [--service URL] [--options OPTIONS] [--workers N] [--check]

DATABASE is a file of SQLite, or postgresql://..., for which psycopg2 is needed. Finds new, changed and removed models below FOLDER and
asks the service for a picture of each; what fails for want of the service is tried again, later each time, until there is nothing left
to try. May be stopped at any time (kill -9 also) and run by several at once: a file that is taken and not brought back is due again.
--check asks again for all, also for those that have failed; what is the same (by its ETag, which is of the model, its files, the options
and the renderer) is not drawn again. OVERCOAT_KEY and OVERCOAT_SALT sign the paths where the service wants that.
"""

import argparse
import base64
import hashlib
import hmac
import http.client
import json
import os
import sqlite3
import sys
import threading
import time
import urllib.parse

# bytes and modified (nanoseconds since 1970) tell whether a file has changed. state is 'due' (to be drawn from the time due on, in seconds
# since 1970), 'drawn' (key has its preview) or 'failed' (for kind and error).
TABLES = ['''CREATE TABLE IF NOT EXISTS files (path TEXT PRIMARY KEY, bytes BIGINT, modified BIGINT, state TEXT, due DOUBLE PRECISION,
             attempts INTEGER, key TEXT, kind TEXT, error TEXT)''',
          '''CREATE TABLE IF NOT EXISTS previews (key TEXT PRIMARY KEY, media_type TEXT, width INTEGER, height INTEGER, warnings TEXT,
             picture BLOB)''']
# Seconds after which a file that was taken is due again; longer than the service takes to answer anything.
TAKEN = 600
# Attempts, and seconds before the second: twice as long each time, up to an hour.
ATTEMPTS, SECONDS = 12, 2
# Answers that another attempt would not change.
FINAL = {400, 404, 410, 413, 415, 422}


class Store:
    """A database."""

    def __init__(self, address):
        self.is_postgres = address.startswith(('postgresql:', 'postgres:'))
        if self.is_postgres:
            import psycopg2
            self.connection = psycopg2.connect(address)
        else:
            self.connection = sqlite3.connect(address, timeout=60)
            self.connection.execute('PRAGMA journal_mode=WAL')

    def run(self, text, *values):
        """Rows of a statement."""
        return self.all((text, values))

    def all(self, *statements):
        """Rows of the last of statements that are one transaction."""
        with self.connection:
            cursor = self.connection.cursor()
            for text, values in statements:
                if self.is_postgres:
                    text = text.replace('%', '%%').replace('?', '%s').replace('BLOB', 'BYTEA')
                cursor.execute(text, values)
            return cursor.fetchall() if cursor.description else []


class Service:
    """A connection to the service."""

    def __init__(self, address, options):
        self.address, self.options = urllib.parse.urlsplit(address), options
        self.key, self.salt = (bytes.fromhex(os.environ.get(name, '')) for name in ('OVERCOAT_KEY', 'OVERCOAT_SALT'))

    def get(self, path, headers={}):
        """Status, headers and body of an answer; one connection each."""
        kind = http.client.HTTPSConnection if self.address.scheme == 'https' else http.client.HTTPConnection
        connection = kind(self.address.netloc, timeout=TAKEN / 2)
        try:
            connection.request('GET', self.address.path.rstrip('/') + path, headers=headers)
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()
        finally:
            connection.close()

    def picture(self, path, key):
        """The answer for a model, or 304 if the picture of this key is still its picture."""
        path = f'/{self.options}/plain/local://{urllib.parse.quote(os.fsencode(path))}@webp'
        mac = hmac.new(self.key, self.salt + path.encode(), hashlib.sha256).digest()
        signature = base64.urlsafe_b64encode(mac).decode().rstrip('=') if self.key else '_'
        return self.get(f'/{signature}{path}', {'If-None-Match': f'"{key}"'} if key else {})


def find(folder, extensions):
    """Path below the folder, bytes and time of every model. A folder that cannot be read is an error and not an empty one."""
    def fail(error):
        raise error
    for at, folders, names in os.walk(folder, onerror=fail):
        folders.sort()
        for name in names:
            path = os.path.join(at, name)
            if name.rpartition('.')[2].lower() in extensions and os.path.isfile(path):
                told = os.stat(path)
                yield os.path.relpath(path, folder), told.st_size, told.st_mtime_ns


def scan(store, folder, extensions):
    """Brings the table of files up to date."""
    found = set()
    for path, size, modified in find(folder, extensions):
        found.add(path)
        store.run('''INSERT INTO files (path, bytes, modified, state, due, attempts) VALUES (?, ?, ?, 'due', 0, 0)
                     ON CONFLICT (path) DO UPDATE SET bytes = excluded.bytes, modified = excluded.modified, state = 'due', due = 0,
                     attempts = 0 WHERE files.bytes <> excluded.bytes OR files.modified <> excluded.modified''', path, size, modified)
    gone = {path for path, in store.run('SELECT path FROM files')} - found
    if gone and not found:
        sys.exit(f'{folder} has no models, and the catalogue has {len(gone)}: is it the right folder?')
    for path in gone:
        store.run('DELETE FROM files WHERE path = ?', path)


def take(store):
    """Takes the file that is due first, so that no other takes it meanwhile."""
    locked = 'FOR UPDATE SKIP LOCKED' if store.is_postgres else ''
    rows = store.run(f'''UPDATE files SET due = ? WHERE path = (SELECT path FROM files WHERE state = 'due' AND due <= ? ORDER BY due, path
                         LIMIT 1 {locked}) RETURNING path, bytes, modified, key, attempts''', time.time() + TAKEN, time.time())
    return rows[0] if rows else None


def draw(store, service, taken):
    """Asks for the picture of a file, and writes down what came of it."""
    path, size, modified, key, attempts = taken
    wait, kind, error, statements = 0, None, None, []
    if not store.run('SELECT key FROM previews WHERE key = ?', key):
        key = None
    try:
        status, headers, body = service.picture(path, key)
    except (OSError, http.client.HTTPException) as failure:
        status, headers, kind, error = 0, {}, 'away', str(failure)
    if status in (401, 403):
        # Of a thread, sys.exit would end nothing else.
        print(f'the service refuses: {body.decode(errors="replace")}', file=sys.stderr)
        os._exit(1)
    if status == 200:
        key = headers['ETag'].strip('"')
        width, _, height = headers['Overcoat-Size'].partition('x')
        preview = (key, headers['Content-Type'], int(width), int(height), headers.get('Overcoat-Warnings', '[]'), body)
        statements.append(('''INSERT INTO previews (key, media_type, width, height, warnings, picture) VALUES (?, ?, ?, ?, ?, ?)
                              ON CONFLICT (key) DO NOTHING''', preview))
    if status in (200, 304):
        state, attempts = 'drawn', 0
    else:
        if status:
            told = json.loads(body)['error'] if headers.get_content_type() == 'application/json' else {}
            kind, error = told.get('kind', str(status)), told.get('message', '')
        attempts += 1
        state = 'failed' if status in FINAL or attempts >= ATTEMPTS else 'due'
        wait = max(float(headers.get('Retry-After') or 0), min(SECONDS * 2 ** (attempts - 1), 3600))
        key = None if state == 'failed' else key
    # Nothing of this for a file that has changed meanwhile: it is due in any case.
    statements.append(('''UPDATE files SET state = ?, due = ?, attempts = ?, key = ?, kind = ?, error = ?
                          WHERE path = ? AND bytes = ? AND modified = ?''',
                       (state, time.time() + wait, attempts, key, kind, error, path, size, modified)))
    store.all(*statements)


def work(asked):
    """Draws until nothing is due any more."""
    store, service = Store(asked.database), Service(asked.service, asked.options)
    while True:
        taken = take(store)
        if taken:
            draw(store, service, taken)
            continue
        (next_due,), = store.run("SELECT MIN(due) FROM files WHERE state = 'due'")
        if next_due is None:
            return
        time.sleep(min(max(next_due - time.time(), 0.1), 5))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('database')
    parser.add_argument('folder')
    parser.add_argument('--service', default='http://127.0.0.1:8080')
    parser.add_argument('--options', default='size:256', help='as in paths of the service [size:256]')
    parser.add_argument('--workers', type=int, default=4, help='requests at a time [4]')
    parser.add_argument('--check', action='store_true')
    asked = parser.parse_args()
    store = Store(asked.database)
    for table in TABLES:
        store.run(table)
    try:
        formats = json.loads(Service(asked.service, '').get('/formats')[2])
    except OSError as error:
        sys.exit(f'{asked.service}: {error}')
    scan(store, asked.folder, {extension for kind in formats['read'] for extension in kind['extensions']})
    if asked.check:
        store.run("UPDATE files SET state = 'due', due = 0, attempts = 0 WHERE state <> 'due'")
    threads = [threading.Thread(target=work, args=(asked,)) for _ in range(asked.workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    store.run('DELETE FROM previews WHERE key NOT IN (SELECT key FROM files WHERE key IS NOT NULL)')
    for state, kind, count in store.run('SELECT state, kind, COUNT(*) FROM files GROUP BY state, kind ORDER BY state, kind'):
        print(count, state, kind or '')


if __name__ == '__main__':
    main()
