#!/usr/bin/env python3
"""Writes a container image of one static program: the archive of an OCI image layout (image-spec 1.1).

Usage: packaging/oci.py PROGRAM NAME VERSION ARCH SOURCE_DATE_EPOCH OUT.tar

NAME is the program's and the image's. The same program and time make the same bytes. manifest.json is for versions of docker load that know no layouts.
"""

import datetime
import gzip
import hashlib
import io
import json
import sys
import tarfile

ARCHITECTURES = {"x86_64": "amd64", "aarch64": "arm64"}
# Nobody: the program needs no right that a user has.
USER = 65532


def add(archive, name, mode, time, content=None):
    """A file, or a folder if it has no content."""
    entry = tarfile.TarInfo(name)
    entry.mode, entry.mtime = mode, time
    if content is None:
        entry.type = tarfile.DIRTYPE
        archive.addfile(entry)
    else:
        entry.size = len(content)
        archive.addfile(entry, io.BytesIO(content))


def layer_of(program, name, time):
    """The file system: the program, and a folder to mount files into."""
    layer = io.BytesIO()
    with tarfile.open(fileobj=layer, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        add(archive, "usr", 0o755, time)
        add(archive, "usr/bin", 0o755, time)
        add(archive, f"usr/bin/{name}", 0o755, time, program)
        add(archive, "mnt", 0o755, time)
    return layer.getvalue()


def config_of(layer, name, version, arch, created):
    """What a container of the image runs."""
    labels = {
        "org.opencontainers.image.title": name,
        "org.opencontainers.image.version": version,
        "org.opencontainers.image.licenses": "MIT OR Apache-2.0",
    }
    return {
        "created": created,
        "architecture": ARCHITECTURES[arch],
        "os": "linux",
        "config": {
            "User": f"{USER}:{USER}",
            "Env": ["PATH=/usr/bin"],
            "Entrypoint": [f"/usr/bin/{name}"],
            "Cmd": ["--help"],
            "WorkingDir": "/mnt",
            "Labels": labels,
        },
        "rootfs": {"type": "layers", "diff_ids": [digest(layer)]},
        "history": [{"created": created, "created_by": "packaging/oci.sh"}],
    }


def digest(data):
    return "sha256:" + hashlib.sha256(data).hexdigest()


def encoded(value):
    return json.dumps(value, sort_keys=True, separators=(",", ":")).encode()


def descriptor(kind, data, **more):
    return {"mediaType": f"application/vnd.oci.image.{kind}", "digest": digest(data), "size": len(data), **more}


def main():
    if len(sys.argv) != 7:
        sys.exit(__doc__.strip())
    program, name, version, arch, time, out = sys.argv[1:]
    time = int(time)
    created = datetime.datetime.fromtimestamp(time, datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    with open(program, "rb") as file:
        layer = layer_of(file.read(), name, time)
    packed = gzip.compress(layer, 9, mtime=0)
    config = encoded(config_of(layer, name, version, arch, created))
    layers = [descriptor("layer.v1.tar+gzip", packed)]
    kind = "manifest.v1+json"
    manifest = encoded({"schemaVersion": 2, "mediaType": f"application/vnd.oci.image.{kind}",
                        "config": descriptor("config.v1+json", config), "layers": layers})
    platform = {"architecture": ARCHITECTURES[arch], "os": "linux"}
    names = {"org.opencontainers.image.ref.name": version, "io.containerd.image.name": f"{name}:{version}"}
    index = encoded({"schemaVersion": 2, "mediaType": "application/vnd.oci.image.index.v1+json",
                     "manifests": [descriptor(kind, manifest, platform=platform, annotations=names)]})

    def path(data):
        return "blobs/sha256/" + hashlib.sha256(data).hexdigest()

    docker = [{"Config": path(config), "RepoTags": [f"{name}:{version}"], "Layers": [path(packed)]}]
    with tarfile.open(out, "w", format=tarfile.USTAR_FORMAT) as archive:
        add(archive, "blobs", 0o755, time)
        add(archive, "blobs/sha256", 0o755, time)
        for blob in sorted([packed, config, manifest], key=path):
            add(archive, path(blob), 0o644, time, blob)
        add(archive, "index.json", 0o644, time, index)
        add(archive, "manifest.json", 0o644, time, encoded(docker))
        add(archive, "oci-layout", 0o644, time, encoded({"imageLayoutVersion": "1.0.0"}))


main()
