#!/bin/sh
# Makes the environment of the project: finds a Python, creates .venv, installs the packages.
#
#   ./install.sh            what running a task needs
#   ./install.sh dev        what the tests need as well
#   PYTHON=/path ./install.sh     with this Python; `./install.sh --which` only names the one it takes
set -u
cd "$(dirname "$0")" || exit 1
VENV=${VENV:-.venv}

# A shim or a broken link has the right name and does not run: so every candidate is asked.
USABLE='import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))'

usable() { "$1" -c "$USABLE" >/dev/null 2>&1; }

find_python() {
    for candidate in python3.11 python3.12 python3.13 python3.14 python3 python; do
        # All of that name on the path: behind a shim that does not work there may be one that does.
        old_ifs=$IFS; IFS=:
        for folder in $PATH; do
            if [ -x "$folder/$candidate" ] && usable "$folder/$candidate"; then
                IFS=$old_ifs
                echo "$folder/$candidate"
                return 0
            fi
        done
        IFS=$old_ifs
    done
    return 1
}

if [ -n "${PYTHON:-}" ]; then
    python=$PYTHON
    if ! usable "$python"; then
        echo "PYTHON=$python: is no Python 3.11 to 3.14 with venv; name another, or leave PYTHON out" >&2
        exit 2
    fi
elif ! python=$(find_python); then
    echo "frankie-task needs Python 3.11 to 3.14 with venv, and there is none on this machine: install one (Debian, Ubuntu: apt install python3 python3-venv; macOS: brew install python@3.14), or name it: make PYTHON=/path/to/python3.12" >&2
    exit 2
fi
if [ "${1:-}" = --which ]; then
    echo "$python"
    exit 0
fi

if [ "${1:-run}" = dev ]; then extras=dev,assets; else extras=assets,physics,page; fi
if [ -x "$VENV/bin/python" ] && usable "$VENV/bin/python"; then python=$VENV/bin/python; fi
version=$("$python" -c 'import platform; print(platform.python_version())')
begun=$(date +%s)
echo "Installing frankie-task into $VENV with Python $version. This happens once: about 1.8 GB, one to five minutes."

echo "[1/3] the virtual environment ($python)"
if ! usable "$VENV/bin/python"; then "$python" -m venv --clear "$VENV" || exit 1; fi

echo "[2/3] the packages: Pinocchio, Rerun and what they need"
log=$VENV/install.log
terminal=0
if [ -t 1 ]; then terminal=1; fi
{
    "$VENV/bin/python" -m pip install --no-compile --progress-bar off --disable-pip-version-check \
        --editable ".[$extras]" --constraint constraints.txt 2>&1
    echo "exit code: $?"
} | tee "$log" | awk -v terminal=$terminal '
    /^Collecting / && terminal { printf "\r\033[K      %d: %s", ++count, $2; fflush() }
    /^Installing collected/ { if (terminal) printf "\r\033[K"; print "      unpacking them"; fflush() }
'
if ! grep -q '^exit code: 0$' "$log"; then
    tail -n 15 "$log" >&2
    echo "the packages could not be installed; all that pip said is in $log" >&2
    exit 1
fi

echo "[3/3] the robot's meshes, made light enough for the viewer, and the schema of tasks for editors"
"$VENV/bin/python" -c "from app.live.monitor.meshes import meshes; meshes()" || exit 1
"$VENV/bin/frankie-task" schema --output trees/frankie-task.schema.json || exit 1

if [ "${1:-run}" = dev ]; then touch "$VENV/developing"; fi
touch "$VENV/installed"
echo "Installed in $(($(date +%s) - begun)) s."
