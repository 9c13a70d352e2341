"""A Ray cluster of two nodes with one processor each on this machine, whose workers and nodes can be killed."""

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
# Ray then detects a dead node within seconds; by default it takes about 15 s.
HEALTH_CHECK = {
    "RAY_health_check_initial_delay_ms": "1000",
    "RAY_health_check_period_ms": "1000",
    "RAY_health_check_timeout_ms": "2000",
    "RAY_health_check_failure_threshold": "3",
}


def descendants(pid: int) -> list[int]:
    """Returns all descendants of a process, from /proc."""
    children: dict[int, list[int]] = {}
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        children.setdefault(int(fields[1]), []).append(int(status.parent.name))
    result, pending = [], [pid]
    while pending:
        pids = children.get(pending.pop(), [])
        result += pids
        pending += pids
    return result


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
    """A `ray start` process with its descendants."""

    def __init__(self, arguments: list[str], directory: str) -> None:
        ray = Path(sys.executable).with_name("ray")
        call = [str(ray), "start", *arguments, f"--node-ip-address={HOST}", "--num-cpus=1", "--block", "--disable-usage-stats"]
        log = Path(directory, f"{'head' if '--head' in arguments else 'second'}.log").open("w")
        environment = {**os.environ, **HEALTH_CHECK, "RAY_TMPDIR": directory}
        self.process = subprocess.Popen(call, stdout=log, stderr=subprocess.STDOUT, env=environment, start_new_session=True)
        log.close()

    def processes(self) -> list[int]:
        return [self.process.pid, *descendants(self.process.pid)]

    def busy_worker(self) -> int | None:
        """Returns a worker process that runs a task of phalanx."""
        return next((pid for pid in self.processes() if "ray::" in command(pid) and "_shard" in command(pid)), None)

    def kill(self) -> None:
        """Kills all processes of the node, like the failure of a machine."""
        for pid in self.processes():
            kill(pid)
        self.process.wait()


@contextmanager
def cluster() -> Iterator[tuple[str, Node, Node]]:
    """Yields the address of a cluster, its head and its second node.

    Import Ray only inside, because it reads the token only once.
    """
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        port = probe.getsockname()[1]
    address = f"{HOST}:{port}"
    # Ray listens on all interfaces and executes arbitrary code for its clients, so the cluster requires a secret token.
    token = {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    os.environ.update(token)
    with tempfile.TemporaryDirectory(prefix="ray-", dir="/tmp", ignore_cleanup_errors=True) as directory:
        nodes: list[Node] = []
        try:
            nodes.append(Node(["--head", f"--port={port}", "--include-dashboard=false"], directory))
            _wait_for_port(port)
            nodes.append(Node([f"--address={address}"], directory))
            yield address, nodes[0], nodes[1]
        finally:
            for node in reversed(nodes):
                node.kill()
            for name in token:
                del os.environ[name]


def _wait_for_port(port: int) -> None:
    for _ in range(600):
        with socket.socket() as probe:
            if probe.connect_ex((HOST, port)) == 0:
                return
        time.sleep(0.1)
    raise TimeoutError("the head of the cluster does not respond")


def wait_for_nodes(ray: object, count: int) -> None:
    """Waits until the cluster has exactly `count` live nodes."""
    for _ in range(600):
        if sum(node["Alive"] for node in ray.nodes()) == count:  # type: ignore[attr-defined]
            return
        time.sleep(0.1)
    raise TimeoutError(f"the cluster does not have {count} nodes")
