"""Sets up the virtual environment that build123d runs in, once per user and lock file, and says where its Python is.

    python set_up.py REQUIREMENTS.txt FALLBACK_FOLDER

The environment is `~/.cache/fibar/environments/build123d-KEY` (the home folder of the user database, since a stage sees
no environment variables of the user), or below FALLBACK_FOLDER where that cannot be written. KEY is a hash over the lock
file and the interpreter. It is made beside its final place and appears by rename, so it is whole or absent; a lock lets
one process do the work while others wait. Only the standard library is used here.

What happens is told on standard output, one `note TEXT` per line, and at last `python PATH` or `failed TEXT`. The exit code
is 0, 7 for an interpreter that will not do, or 8 when the environment cannot be made.
"""

import hashlib
import os
import platform
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

OLDEST, NEWEST = (3, 11), (3, 14)
UNSUITABLE, NOT_MADE = 7, 8


class NotMade(Exception):
    """Why there is no environment."""


def main(lock: Path, fallback: Path) -> int:
    if not OLDEST <= sys.version_info[:2] <= NEWEST:
        say("failed", f"Python {platform.python_version()} is not 3.11 to 3.14")
        return UNSUITABLE
    try:
        say("python", ensure(lock, fallback))
        return 0
    except (NotMade, OSError) as error:
        say("failed", error)
        return NOT_MADE


def ensure(lock: Path, fallback: Path) -> Path:
    """The Python of the environment, which is made if there is none yet."""
    folder = environments(fallback) / f"build123d-{key(lock)}"
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not python.exists():
        with alone(folder.with_suffix(".lock")):
            if not python.exists():
                make(folder, lock)
    return python


def key(lock: Path) -> str:
    """Names the environment by what goes into it."""
    interpreter = f"{sys.implementation.cache_tag} {platform.machine()} {os.path.realpath(sys.executable)}"
    return hashlib.sha256(lock.read_bytes() + interpreter.encode()).hexdigest()[:16]


def environments(fallback: Path) -> Path:
    """The folder of all environments."""
    for folder in (home() / ".cache" / "fibar" / "environments", fallback):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                return folder
        except OSError:
            pass
    raise NotMade(f"neither {home() / '.cache'} nor {fallback} can be written")


def home() -> Path:
    """The user's home by the user database: HOME is a stage's private folder."""
    try:
        import pwd

        return Path(pwd.getpwuid(os.getuid()).pw_dir)
    except (ImportError, KeyError):
        return Path(os.path.expanduser("~"))


@contextmanager
def alone(path: Path):
    """Waits until no other process is in here."""
    with open(path, "w") as file:
        try:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        except ImportError:
            pass
        yield


def make(folder: Path, lock: Path) -> None:
    say("note", f"setting up build123d in {folder} (once, about a minute and 1 GB)")
    work = folder.with_name(f"{folder.name}.{os.getpid()}")
    try:
        run("venv", work)
        python = next(p for p in (work / "bin/python", work / "Scripts/python.exe") if p.exists())
        install = "install --quiet --disable-pip-version-check --require-hashes --no-deps --only-binary :all: --requirement"
        run("pip", *install.split(), lock, python=python)
        os.replace(work, folder)
    finally:
        shutil.rmtree(work, ignore_errors=True)


def run(module: str, *arguments, python=sys.executable) -> None:
    """Runs a module of an interpreter; a failure says the last of what it printed."""
    command = [str(word) for word in (python, "-I", "-m", module, *arguments)]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    if result.returncode:
        lines = [line.strip() for line in result.stdout.splitlines() if line.strip()]
        errors = [line for line in lines if line.startswith(("ERROR", "Error"))] or lines
        raise NotMade(f"{module}: {' '.join(errors[:4]) or f'exit code {result.returncode}'}"[:600])


def say(what: str, text) -> None:
    print(what, str(text).replace("\n", " "), flush=True)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
