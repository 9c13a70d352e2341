"""A Ray cluster of two nodes on this machine, a processor each, whose workers and nodes can be killed."""

from __future__ import annotations

import os
import secrets
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

HOST = "127.0.0.1"
# A dead node is noticed in seconds, not in a quarter of a minute as by default.
HEALTH = {
    "RAY_health_check_initial_delay_ms": "1000",
    "RAY_health_check_period_ms": "1000",
    "RAY_health_check_timeout_ms": "2000",
    "RAY_health_check_failure_threshold": "3",
}


def descendants(pid: int) -> list[int]:
    """All processes below one, from the kernel's table."""
    children: dict[int, list[int]] = {}
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        children.setdefault(int(fields[1]), []).append(int(status.parent.name))
    found, open_ = [], [pid]
    while open_:
        of = children.get(open_.pop(), [])
        found += of
        open_ += of
    return found


def command(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    except OSError:
        return ""


def kill(pid: int) -> None:
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


class Node:
    """One `ray start`, with everything it starts."""

    def __init__(self, arguments: list[str], directory: str) -> None:
        ray = Path(sys.executable).with_name("ray")
        call = [str(ray), "start", *arguments, f"--node-ip-address={HOST}", "--num-cpus=1", "--block", "--disable-usage-stats"]
        log = Path(directory, f"{'head' if '--head' in arguments else 'second'}.log").open("w")
        environment = {**os.environ, **HEALTH, "RAY_TMPDIR": directory}
        self.process = subprocess.Popen(call, stdout=log, stderr=subprocess.STDOUT, env=environment, start_new_session=True)
        log.close()

    def processes(self) -> list[int]:
        return [self.process.pid, *descendants(self.process.pid)]

    def busy_worker(self) -> int | None:
        """A worker that is at one of our tasks."""
        return next((pid for pid in self.processes() if "ray::" in command(pid) and "_shard" in command(pid)), None)

    def kill(self) -> None:
        """All of it at once, as when a machine is gone; then whatever it started meanwhile."""
        known = self.processes()
        for pid in known:
            kill(pid)
        self.process.wait()


@contextmanager
def cluster() -> Iterator[tuple[str, Node, Node]]:
    """The address of a cluster, its head and its second node. Ray is imported within it: its library looks for the token once."""
    with socket.socket() as free:
        free.bind((HOST, 0))
        port = free.getsockname()[1]
    address = f"{HOST}:{port}"
    # Ray listens on all interfaces, and whoever may talk to it may run anything: only who has this cluster's own token may.
    token = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    os.environ.update(token)
    with tempfile.TemporaryDirectory(prefix="ray-", dir="/tmp", ignore_cleanup_errors=True) as directory:
        started: list[Node] = []
        try:
            started.append(Node(["--head", f"--port={port}", "--include-dashboard=false"], directory))
            _answers(port)
            started.append(Node([f"--address={address}"], directory))
            yield address, started[0], started[1]
        finally:
            for node in reversed(started):
                node.kill()
            for name in token:
                del os.environ[name]


def _answers(port: int) -> None:
    for _ in range(600):
        with socket.socket() as probe:
            if probe.connect_ex((HOST, port)) == 0:
                return
        time.sleep(0.1)
    raise TimeoutError("the head of the cluster does not answer")


def wait_for_nodes(ray: object, count: int) -> None:
    """Until so many nodes are there, a worker's start included."""
    for _ in range(600):
        if sum(node["Alive"] for node in ray.nodes()) == count:  # type: ignore[attr-defined]
            return
        time.sleep(0.1)
    raise TimeoutError(f"the cluster has not {count} nodes")
