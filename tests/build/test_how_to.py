# SPDX-License-Identifier: GPL-3.0-or-later
"""The plugin of docs/plugin-how-to.md builds and runs by the commands that stand there."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pymeshlab

ROOT = Path(__file__).parents[2]


def fenced(text: str, language: str) -> str:
    """The first block of code in this language."""
    return re.search(rf"^```{re.escape(language)}\n(.*?)^```$", text, re.M | re.S)[1]


def test_the_plugin_of_the_how_to_builds_and_counts_faces(tmp_path):
    chapter = (ROOT / "docs" / "plugin-how-to.md").read_text().split("## Build\n")[1]
    (tmp_path / "CMakeLists.txt").write_text(fenced(chapter, "cmake"))
    (tmp_path / "filter_example.cpp").write_text(fenced(chapter, "c++"))
    fetched = subprocess.run(
        ROOT / "scripts" / "fetch_meshlab_headers.sh", capture_output=True, text=True, check=True
    )
    commands = re.search(r"^```\n(cmake .*?)^```$", chapter, re.M | re.S)[1]
    for name, value in {
        "python": sys.executable,
        "MESHLAB_SOURCES": fetched.stdout.strip(),
        "PYMESHLAB": pymeshlab.__path__[0],
    }.items():
        commands = re.sub(rf"(?<![\w.]){name}\b", shlex.quote(value), commands)
    done = subprocess.run(["sh", "-ec", commands], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == "{'face_count': 12}"
    assert done.stdout.splitlines()[-1] in chapter
    plugin = tmp_path / "build" / "libfilter_example.so"
    assert str(Path(pymeshlab.__path__[0])).encode() not in plugin.read_bytes()
