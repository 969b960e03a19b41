# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs inputs of the fuzzer, one file each, into one text file with a line of hex each, and back.

corpus.py pack FOLDER CORPUS.txt
corpus.py unpack CORPUS.txt FOLDER
"""

import sys
from pathlib import Path


def pack(folder: Path, corpus: Path) -> None:
    lines = {path.read_bytes().hex() for path in folder.iterdir()}
    corpus.write_text("".join(f"{line}\n" for line in sorted(lines, key=lambda x: (len(x), x))))


def unpack(corpus: Path, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number, line in enumerate(corpus.read_text().split()):
        (folder / f"{number:04}").write_bytes(bytes.fromhex(line))


if __name__ == "__main__":
    action, source, target = sys.argv[1:]
    {"pack": pack, "unpack": unpack}[action](Path(source), Path(target))
