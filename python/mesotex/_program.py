"""Runs the program."""

import json
import os
import shutil
import subprocess
import sysconfig
from pathlib import Path


class CommandError(RuntimeError):
    """A command failed. `error` has the parts of its message; `exit_code` is 1 for data, 2 for usage."""

    def __init__(self, words, exit_code, error):
        super().__init__(error.get("message", f"exit code {exit_code}"))
        self.words = words
        self.exit_code = exit_code
        self.error = error


def program():
    """The path of the program: MESOTEX where that is set, else the one installed beside this package, else PATH's."""
    named = os.environ.get("MESOTEX")
    if named:
        return named
    name = "mesotex" + (sysconfig.get_config_var("EXE") or "")
    beside = Path(sysconfig.get_path("scripts")) / name
    found = str(beside) if beside.is_file() else shutil.which("mesotex")
    if found is None:
        raise FileNotFoundError("no program mesotex; install the package, or set MESOTEX to its path")
    return found


def run(command, *words, threads=None, seed=None):
    """Runs a command and returns its report, a dict; raises CommandError where it fails.

    `run("textons", "weave.sample", "-o", "weave.textons.npz", "--textons", 100)`
    """
    line = [program(), command, *map(str, words), "--json"]
    for option, value in (("--threads", threads), ("--seed", seed)):
        if value is not None:
            line += [option, str(value)]
    done = subprocess.run(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    try:
        report = json.loads(done.stdout)
    except ValueError:
        report = {}
    if done.returncode == 0:
        return report
    error = report.get("error") or {"message": done.stderr.decode("utf-8", "replace").strip()}
    raise CommandError(line[1:], done.returncode, error)
