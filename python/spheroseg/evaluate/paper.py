# SPDX-License-Identifier: GPL-3.0-or-later
"""Table 1 of the paper: 21 models in 200 sub-meshes."""

from dataclasses import dataclass
from pathlib import Path

SUBMESH_COUNT = 200


@dataclass(frozen=True)
class PaperResult:
    coefficient_of_variation: float
    max_triangle_count_difference: int
    bowtie_count: int
    boundary_edge_count: int


# Model, triangles, then CV, MTCD, bowties, BE of the paper's method, region growing and METIS.
_TABLE = """
elf 68384 0.00 1 0 5667 0.62 1509 0 9737 0.01 10 0 5695
monster 48904 0.00 1 0 4735 0.61 885 0 8049 0.01 6 0 4835
armadillo 9996 0.00 1 0 2033 0.39 169 0 2985 0.02 3 45 2149
bunny 3996 0.01 1 0 1303 0.34 41 0 1695 0.02 2 143 1447
cow 5804 0.00 1 0 1580 0.34 57 0 2112 0.02 2 19 1631
david 10390 0.00 1 0 1963 0.19 60 0 3011 0.02 3 34 2163
gargoyle 6322 0.00 1 0 1538 0.28 60 0 2192 0.03 3 14 1702
horse 17332 0.01 1 0 2657 0.27 105 0 4198 0.02 5 0 2903
human 20096 0.00 1 0 3041 0.35 182 0 4749 0.01 6 0 3182
man_head 20658 0.00 1 0 2805 0.29 171 0 4838 0.02 6 13 3205
triceratops 4996 0.01 1 0 1459 0.44 55 0 1947 0.01 2 62 1607
dolphin 3730 0.03 1 0 1264 0.47 62 0 1634 0.03 1 67 1381
dog 3200 0.00 0 0 1199 0.30 26 0 1458 0.05 2 27 1229
car 6550 0.01 1 0 1652 0.29 54 0 2274 0.03 3 48 1824
merman 86206 0.00 1 0 6494 0.99 3882 0 11046 0.01 21 6 6210
volleyball 7680 0.01 1 0 1853 0.39 79 0 2512 0.02 2 27 1947
troll 4958 0.02 1 0 1460 0.37 54 0 1992 0.02 3 111 1579
exterminator 6346 0.01 1 0 1677 0.33 67 0 2350 0.03 3 3 1671
sculpture1 156240 0.00 1 0 9060 1.52 2834 0 24954 0.001 4 0 10357
sculpture2 319200 0.00 0 0 13030 1.24 4215 0 46588 0.001 6 44 15176
rock 558976 0.00 1 0 15162 0.50 7301 0 37727 0.001 10 0 16700
"""
_COLUMNS = ("all_pairs", "region_growing", "metis_kway")


def _parse() -> dict[tuple[str, int], dict[str, PaperResult]]:
    table = {}
    for line in _TABLE.split("\n"):
        if line:
            model, triangle_count, *numbers = line.split()
            table[model, int(triangle_count)] = {
                method: PaperResult(
                    float(numbers[i]), int(numbers[i + 1]), int(numbers[i + 2]), int(numbers[i + 3])
                )
                for method, i in zip(_COLUMNS, (0, 4, 8), strict=True)
            }
    return table


_RESULTS = _parse()


def lookup(file: str, triangle_count: int, submesh_count: int, method: str) -> PaperResult | None:
    """The paper's numbers where the name of the mesh file without its suffix, triangle count, k and
    method are those of its table."""
    if submesh_count != SUBMESH_COUNT:
        return None
    return _RESULTS.get((Path(file).stem.lower(), triangle_count), {}).get(method)
