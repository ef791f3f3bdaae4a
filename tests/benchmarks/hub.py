"""Benchmark of a class on one server: ``python tests/benchmarks/hub.py [students]``.

Starts a real JupyterHub on 127.0.0.1 with eight students who open notebooks 02 and 05 at once, first
without and then with a seed folder, and prints seconds and memory. It needs, beside environment.txt,
``pip install jupyterhub psutil`` and ``npm install configurable-http-proxy`` (here or on the PATH).
"""

import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import uuid
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from statistics import median

import nbformat
import psutil
import requests
import websocket

ROOT = Path(__file__).parents[2]
TOKEN = uuid.uuid4().hex
# Environment and timeout are a class's (notebooks/labs/README.md); the rest makes a trial of it.
CONFIG = """
c.JupyterHub.authenticator_class = "dummy"
c.JupyterHub.spawner_class = "simple"
c.Spawner.environment = {{"PENDLAB_SEED": "{seed}", "PYTHONPATH": "{root}"}}
c.Spawner.default_url = "/lab/tree/00_start_here.ipynb"
c.Authenticator.allow_all = True
c.SimpleLocalProcessSpawner.home_dir_template = "{home}/{{username}}"
c.Spawner.cmd = ["{python}", "-m", "jupyterhub.singleuser"]
c.Spawner.args = ["--allow-root"]
c.Spawner.start_timeout = c.Spawner.http_timeout = 300
c.JupyterHub.bind_url = "http://127.0.0.1:{port}"
c.JupyterHub.hub_port = {hub}
c.ConfigurableHTTPProxy.command = ["{proxy}"]
c.ConfigurableHTTPProxy.api_url = "http://127.0.0.1:{api}"
c.JupyterHub.services = [{{"name": "class", "api_token": "{token}"}}]
c.JupyterHub.load_roles = [{{"name": "class", "services": ["class"],
    "scopes": ["admin:users", "admin:servers", "access:servers"]}}]
"""


def free_ports(count):
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


@contextmanager
def hub(folder, seed):
    """A hub that keeps everything in `folder`; gives its address."""
    here = Path(__file__).parent / "node_modules" / ".bin" / "configurable-http-proxy"
    proxy = shutil.which("configurable-http-proxy") or str(here)
    port, api, inner = free_ports(3)
    text = CONFIG.format(seed=seed, root=ROOT, home=folder, python=sys.executable, port=port,
                         hub=inner, proxy=proxy, api=api, token=TOKEN)  # fmt: skip
    (folder / "config.py").write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "jupyterhub", "-f", "config.py"]
    with (folder / "log").open("w") as log:
        running = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log)
        try:
            address = f"http://127.0.0.1:{port}"
            wait(lambda: requests.get(f"{address}/hub/api", timeout=5).ok)
            yield address
        finally:
            family = [running, *psutil.Process(running.pid).children(recursive=True)]
            running.terminate()
            for process in family:
                try:
                    process.wait(20)
                except (subprocess.TimeoutExpired, psutil.TimeoutExpired):
                    process.kill()


def wait(ready, seconds=300):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            if ready():
                return
        except requests.RequestException:
            pass
        time.sleep(0.2)
    raise TimeoutError("the hub did not answer in time; see its log")


def ask(method, address, **data):
    answer = requests.request(
        method, address, headers={"Authorization": f"token {TOKEN}"}, json=data or None, timeout=300
    )
    answer.raise_for_status()
    return answer.json() if answer.content else None


def cells(notebook, until=None):
    """Sources of a notebook's code cells, or those needed for the cell `until`."""
    found = nbformat.read(ROOT / "notebooks" / f"{notebook}.ipynb", as_version=4).cells
    code = [cell for cell in found if cell.cell_type == "code"]
    return [c.source for c in code if until is None or c.id in until]


def student(address, name, start):
    """One student: server, then 05 to the bench panel, then all of 02; seconds since `start`."""
    ask("POST", f"{address}/hub/api/users/{name}")
    ask("POST", f"{address}/hub/api/users/{name}/server")
    user = f"{address}/hub/api/users/{name}"
    wait(lambda: ask("GET", user)["servers"].get("", {}).get("ready"))
    seconds = [time.monotonic() - start]
    for sources in (cells("05_experimental_results", PANEL), cells("02_system_and_models")):
        kernel = ask("POST", f"{address}/user/{name}/api/kernels", name="python3")["id"]
        run(f"{address.replace('http', 'ws')}/user/{name}/api/kernels/{kernel}/channels", sources)
        seconds.append(time.monotonic() - start)
    return seconds


PANEL = ("05-imports", "05-panel-show")


def run(channel, sources):
    """Execute cells one after the other in a kernel, as Lab does."""
    line = websocket.create_connection(
        channel, header=[f"Authorization: token {TOKEN}"], timeout=600
    )
    for source in sources:
        number = uuid.uuid4().hex
        header = {"msg_id": number, "msg_type": "execute_request", "session": number, "version": "5.3"}  # fmt: skip
        content = {"code": source, "silent": False, "stop_on_error": True}
        message = {"header": header, "parent_header": {}, "metadata": {}, "content": content}
        line.send(json.dumps({**message, "channel": "shell", "buffers": []}))
        while True:
            frame = line.recv()
            if isinstance(frame, bytes):
                continue  # a picture of a widget
            reply = json.loads(frame)
            if reply["msg_type"] == "execute_reply" and reply["parent_header"]["msg_id"] == number:
                assert reply["content"]["status"] == "ok", reply["content"]
                break
    line.close()


def memory(name):
    """Proportional set size of all processes whose home is the student's, MB: server and kernels."""
    total = []
    for process in psutil.process_iter():
        try:
            if process.environ().get("JUPYTERHUB_USER") == name:
                total.append(process.memory_full_info().pss / 1e6)
        except (psutil.AccessDenied, psutil.NoSuchProcess, psutil.ZombieProcess):
            continue
    return sum(total)


def trial(title, students, seed):
    folder = Path(tempfile.mkdtemp(prefix="hub"))
    names = [f"student{k}" for k in range(students)]
    for name in names:
        (folder / name).mkdir()
    with hub(folder, seed) as address, ThreadPoolExecutor(students) as pool:
        start = time.monotonic()
        rows = list(pool.map(lambda name: student(address, name, start), names))
        each = [memory(name) for name in names]
    ready, panel, rest = (max(column) for column in zip(*rows))
    print(f"{title}: servers {ready:.0f} s, bench panels {panel:.0f} s, all of 02 {rest:.0f} s; "
          f"{median(each):.0f} MB for each student", flush=True)  # fmt: skip
    shutil.rmtree(folder, ignore_errors=True)
    return panel - ready


if __name__ == "__main__":
    os.environ.pop("PENDLAB_CACHE", None)
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    print(f"{count} students, {os.cpu_count()} cores, load before {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as seed:
        cold = trial("without a seed", count, "")
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-m", "pendlab", "warm", seed]
        subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL)
        warm = trial("with a seed", count, seed)
    print(f"server to panel: {warm:.0f} s with a seed, {warm / cold:.2f} of {cold:.0f} s without")
