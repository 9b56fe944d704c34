"""A process with the commands imported that forks one for every call, so that calls can be killed and starved.

Started by `Zygote`, not by pytest: a process that has threads must not fork.
"""

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Ended:
    """The end of a call: an exit code, or minus the signal that killed it."""

    code: int
    err: str
    seconds: float


class Zygote:
    """Start it; call commands in processes of their own; stop it."""

    def __init__(self):
        self._process = subprocess.Popen(
            [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT
        )

    def __call__(self, *calls, kill_after=None, uid=None, fsize=None):
        """Run command lines at the same time, each a list of a verb and arguments.

        Parameters
        ----------
        kill_after : seconds before SIGKILL
        uid : user to become
        fsize : bytes that a file may have
        """
        request = {"calls": [[str(word) for word in call] for call in calls]}
        request |= {"kill_after": kill_after, "uid": uid, "fsize": fsize}
        print(json.dumps(request), file=self._process.stdin, flush=True)
        return [Ended(*each) for each in json.loads(self._process.stdout.readline())]

    def stop(self):
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()


def _call(words, request, err):
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(err, 2)
    if request["fsize"] is not None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # then writing fails, as on a full disk
        resource.setrlimit(resource.RLIMIT_FSIZE, (request["fsize"],) * 2)
    if request["uid"] is not None:
        os.setgroups([])
        os.setgid(request["uid"])
        os.setuid(request["uid"])
    os._exit(VERBS[words[0]].main(words[1:]))


def _serve(request):
    children = []
    start = time.monotonic()
    for words in request["calls"]:
        err, theirs = os.pipe()  # not a file, whose size may be limited
        pid = os.fork()
        if pid == 0:
            try:
                _call(words, request, theirs)
            except BaseException:
                traceback.print_exc()
            os._exit(99)
        os.close(theirs)
        children.append((pid, err))
    if request["kill_after"] is not None:
        time.sleep(request["kill_after"])
        for pid, _ in children:
            os.kill(pid, signal.SIGKILL)
    ended = []
    for pid, err in children:
        _, status = os.waitpid(pid, 0)
        with open(err, errors="replace") as pipe:
            text = pipe.read()
        ended.append([os.waitstatus_to_exitcode(status), text, time.monotonic() - start])
    return ended


def _warm_up():
    """Load what is loaded when it is first needed; without a thread, or forks would hang."""
    with tempfile.TemporaryDirectory() as folder, open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):
        clip, out = f"{folder}/in.usda", f"{folder}/out"
        make_rig(clip, codes=range(20), rotations=random_rotations(20, 3))
        write_bvh(Path(folder, "in.bvh"))
        VERBS["upsample"].main([clip, "-o", f"{out}.usdz", "--factor", "2", "--alpha", "2"])
        VERBS["learn"].main([clip, "-o", f"{out}.usda"])
        VERBS["downsample"].main([clip, "-o", f"{out}.usda", "--rate", "0.3", "--select", "uniform"])
        VERBS["from_bvh"].main([f"{folder}/in.bvh", "-o", f"{out}.usdc"])
    assert len(os.listdir("/proc/self/task")) == 1, "there are threads"


if __name__ == "__main__":
    os.environ |= dict.fromkeys(("PXR_WORK_THREAD_LIMIT", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    sys.path.insert(0, str(ROOT))
    from bvh_files import write_bvh
    from rigs import make_rig, random_rotations

    from usd_tools import downsample, from_bvh, inspect, learn, upsample

    VERBS = {"upsample": upsample, "inspect": inspect, "learn": learn, "downsample": downsample, "from_bvh": from_bvh}
    _warm_up()
    for line in sys.stdin:
        print(json.dumps(_serve(json.loads(line))), flush=True)
